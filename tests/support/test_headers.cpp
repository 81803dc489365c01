// Nothing of its own: its target has the precompiled header that tests share.

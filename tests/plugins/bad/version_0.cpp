// Built for an interface older than any.
extern "C" __attribute__((visibility("default"))) int lithe_plugin_v0(const void*) { return 0; }

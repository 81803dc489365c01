// Built for an interface of the future.
extern "C" __attribute__((visibility("default"))) int lithe_plugin_v99(const void*) { return 0; }

// The library beneath FMUs, lithe_fmu, is all of Lithe; it needs a source of its own.

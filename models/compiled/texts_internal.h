#pragma once

namespace lithe {

/// runtime_internal.h and program_internal.h, as text.
extern const char* const kCompiledRuntime;
extern const char* const kCompiledProgram;

}  // namespace lithe

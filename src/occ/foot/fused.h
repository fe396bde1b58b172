// Code compiled twice: for any processor, and for those with fused multiplication and addition.
#pragma once

// Four doubles in a register, three operands an instruction, multiplication and addition in one.
#if defined(__x86_64__)
#define PATCHWRIGHT_FUSED [[gnu::target("avx2,fma")]]
#else
#define PATCHWRIGHT_FUSED
#endif

namespace patchwright::occ {

inline bool detect_fused_multiply_add() {
#if defined(__x86_64__)
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
    return false;
#endif
}
/// Whether functions marked PATCHWRIGHT_FUSED may be called.
inline const bool has_fused_multiply_add = detect_fused_multiply_add();

}  // namespace patchwright::occ

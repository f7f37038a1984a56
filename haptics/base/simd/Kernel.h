#pragma once

#include "haptics/base/simd/InstructionSet.h"

#include <tuple>
#include <type_traits>

namespace midair::base
{

/// A function that is compiled once per instruction set. A call runs the version for the set in
/// use.
///
///     extern const base::Kernel<float(int count, const float* x)> sumOf; // in a header
///
///     // SumKernels.cpp, compiled once per set, see midair_kernels() in CMake
///     namespace MIDAIR_SET { float sumOf(int count, const float* x) { .. } }
///
///     MIDAIR_KERNEL(sumOf); // in a source that is compiled once
///
/// More signatures make overloads; define them with MIDAIR_KERNEL_OF_TWO or .._OF_THREE.
template<typename... Functions>
class Kernel : private Kernel<Functions>...
{
public:
    template<int kIndex>
    using FunctionOf = std::tuple_element_t<kIndex, std::tuple<Functions...>>;

    constexpr explicit Kernel(Kernel<Functions>... overloads) : Kernel<Functions>(overloads)... {}

    using Kernel<Functions>::operator()...;
};

template<typename Result, typename... Arguments>
class Kernel<Result(Arguments...)>
{
public:
    using Function = Result(Arguments...);

    constexpr Kernel(Function* plain, Function* avx2, Function* avx512) :
        _forms{plain, avx2, avx512}
    {
    }

    Result operator()(Arguments... arguments) const
    {
        return _forms[static_cast<int>(instructionSet())](arguments...);
    }

private:
    Function* _forms[3];
};

// Declares the versions of a kernel and defines it. midair_kernels() compiles the versions into
// these namespaces.
#ifdef MIDAIR_HAS_SIMD
#define MIDAIR_FORMS(name) plain::name, avx2::name, avx512::name
#define MIDAIR_DECLARE(name, Function)                                                             \
    namespace plain                                                                                \
    {                                                                                              \
    KernelOf_##name::Function name;                                                                \
    }                                                                                              \
    namespace avx2                                                                                 \
    {                                                                                              \
    KernelOf_##name::Function name;                                                                \
    }                                                                                              \
    namespace avx512                                                                               \
    {                                                                                              \
    KernelOf_##name::Function name;                                                                \
    }
#else
#define MIDAIR_FORMS(name) plain::name, nullptr, nullptr
#define MIDAIR_DECLARE(name, Function)                                                             \
    namespace plain                                                                                \
    {                                                                                              \
    KernelOf_##name::Function name;                                                                \
    }
#endif
#define MIDAIR_KERNEL(name)                                                                        \
    using KernelOf_##name = std::remove_const_t<decltype(name)>;                                   \
    MIDAIR_DECLARE(name, Function)                                                                 \
    const KernelOf_##name name(MIDAIR_FORMS(name))
#define MIDAIR_KERNEL_OF_TWO(name)                                                                 \
    using KernelOf_##name = std::remove_const_t<decltype(name)>;                                   \
    MIDAIR_DECLARE(name, FunctionOf<0>)                                                            \
    MIDAIR_DECLARE(name, FunctionOf<1>)                                                            \
    const KernelOf_##name name({MIDAIR_FORMS(name)}, {MIDAIR_FORMS(name)})
#define MIDAIR_KERNEL_OF_THREE(name)                                                               \
    using KernelOf_##name = std::remove_const_t<decltype(name)>;                                   \
    MIDAIR_DECLARE(name, FunctionOf<0>)                                                            \
    MIDAIR_DECLARE(name, FunctionOf<1>)                                                            \
    MIDAIR_DECLARE(name, FunctionOf<2>)                                                            \
    const KernelOf_##name name({MIDAIR_FORMS(name)}, {MIDAIR_FORMS(name)}, {MIDAIR_FORMS(name)})

} // namespace midair::base

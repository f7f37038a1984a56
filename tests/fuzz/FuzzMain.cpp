#include "tests/fuzz/FuzzTargets.h"

/// MIDAIR_FUZZ_TARGET is what this program fuzzes.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    MIDAIR_FUZZ_TARGET(data, size);
    return 0;
}

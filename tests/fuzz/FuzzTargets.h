#pragma once

#include <cstddef>
#include <cstdint>

/// What is fuzzed. Each aborts when a promise is broken that no input may break; both are run by libFuzzer (FuzzProtocol.cpp,
/// FuzzRecording.cpp; run.sh) and on the corpus by the tests (ReplayTest.cpp).

/// Bytes to a device, cut into transfers by the first bytes: no read outside of them, whole packets are found again after
/// garbage, a field never plays half, the device's answers are packets.
void fuzzProtocol(const std::uint8_t* data, std::size_t size);

/// A recording's bytes: no read outside of them, every entry is whole, times ascend, reading ends.
void fuzzRecording(const std::uint8_t* data, std::size_t size);

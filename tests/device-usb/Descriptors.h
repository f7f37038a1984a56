#pragma once

#include <cstdint>
#include <string>
#include <vector>

// What the emulated devices say that they are, in hexadecimal.

// The array: a first interface of another kind, then ours.
inline constexpr const char* kDescriptors = "12010002000000400912010000010102"
                                            "0301"
                                            "09022900020100"
                                            "8032"
                                            "0904000000FF000000"
                                            "0904010002FF4D4800"
                                            "07050302000200"
                                            "07058602000200";

// FT232H, 0403:6014, release 9.00; vendor interface with bulk IN 1 and bulk OUT 2.
inline constexpr const char* kFifoDescriptors = "1201000200000040030414600009010203"
                                                "01"
                                                "090220000101008032"
                                                "0904000002FFFFFF00"
                                                "07058102000200"
                                                "07050202000200";

inline std::vector<std::uint8_t> stringDescriptor(const std::string& text)
{
    std::vector<std::uint8_t> bytes = {static_cast<std::uint8_t>(2 + 2 * text.size()), 3};
    for (const char letter : text)
    {
        bytes.push_back(static_cast<std::uint8_t>(letter));
        bytes.push_back(0);
    }
    return bytes;
}

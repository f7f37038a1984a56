#pragma once

#include <cstdint>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

/// Reads bytes as the wire format's examples are written: "02 FF*28 00..F8 (T)": 28 times, counting
/// up, and a time of eight bytes, here 08 07 .. 01.
inline std::vector<std::uint8_t> bytesOf(const std::string& text)
{
    const auto byte = [](const std::string& digits)
    {
        std::size_t used = 0;
        const unsigned long value = std::stoul(digits, &used, 16);
        if (used != 2 || digits.size() != 2) throw std::invalid_argument(digits);
        return static_cast<std::uint8_t>(value);
    };
    std::vector<std::uint8_t> bytes;
    std::istringstream words(text);
    for (std::string word; words >> word;)
    {
        const std::size_t star = word.find('*');
        const std::size_t dots = word.find("..");
        if (word == "(T)")
            for (std::uint8_t b = 8; b > 0; --b)
                bytes.push_back(b);
        else if (star != std::string::npos)
            bytes.insert(
                bytes.end(), std::stoul(word.substr(star + 1)), byte(word.substr(0, star)));
        else if (dots != std::string::npos)
            for (int b = byte(word.substr(0, dots)); b <= byte(word.substr(dots + 2)); ++b)
                bytes.push_back(static_cast<std::uint8_t>(b));
        else
            bytes.push_back(byte(word));
    }
    return bytes;
}

constexpr std::uint64_t kTextTime_ns = 0x0102030405060708; ///< "(T)"

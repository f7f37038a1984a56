#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

/// A file name in a folder that the test program may write to, free of what an earlier run left.
inline std::string temporaryFile(const std::string& name)
{
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    std::string full =
        std::string("midair_") + test->test_suite_name() + "_" + test->name() + "_" + name;
    std::replace(full.begin(), full.end(), '/', '_');
    const std::string path = ::testing::TempDir() + std::to_string(::getpid()) + "_" + full;
    std::filesystem::remove(path);
    return path;
}

inline std::vector<std::uint8_t> readBytes(const std::string& path)
{
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

inline void writeBytes(const std::string& path, const std::vector<std::uint8_t>& bytes)
{
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
}

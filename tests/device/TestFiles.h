#pragma once

#include "device/ArrayDevice.h"
#include "device/recording/Recording.h"

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

inline void append(std::vector<std::uint8_t>& all, const std::vector<std::uint8_t>& more)
{
    all.insert(all.end(), more.begin(), more.end());
}

/// The whole fields and silences of a recording.
inline std::vector<midair::device::recording::Entry> entriesOf(const std::string& file)
{
    const auto bytes = readBytes(file);
    midair::device::recording::Reader reader(bytes.data(), bytes.size(), file);
    std::vector<midair::device::recording::Entry> entries;
    midair::device::recording::Entry entry;
    while (reader.next(entry) == midair::device::recording::Stop::MORE)
        entries.push_back(entry);
    return entries;
}

/// What opening \a uri throws; "no error" where it opens.
inline std::string openError(const std::string& uri,
                             const midair::device::DeviceLayout& layout = {4, {}})
{
    try
    {
        midair::device::openDevice(uri, layout);
    }
    catch (const midair::device::DeviceError& error)
    {
        return error.what();
    }
    return "no error";
}

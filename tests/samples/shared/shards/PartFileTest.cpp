#include "haptics/base/InputError.h"
#include "samples/shared/shards/Shards.h"

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

namespace midair::samples
{
namespace
{

class Parts : public testing::Test
{
protected:
    Parts() :
        path(testing::TempDir() + "midair-part-" +
             testing::UnitTest::GetInstance()->current_test_info()->name())
    {
        std::filesystem::remove(path);
    }
    ~Parts() override { std::filesystem::remove(path); }

    static PartHeader header(int shard = 1, int shards = 1)
    {
        return {{{"what", "test"}, {"frames", {1, 2}}}, shard, shards, 5};
    }
    std::string bytes() const
    {
        std::ostringstream all;
        all << std::ifstream(path, std::ios::binary).rdbuf();
        return all.str();
    }
    void write(const std::string& content) const
    {
        std::ofstream(path, std::ios::binary) << content;
    }

    const std::string path;
};

TEST_F(Parts, EachPieceBelongsToOneShard)
{
    for (const int shards : {1, 2, 3, 5, 7})
    {
        std::uint64_t all = 0;
        for (std::uint64_t piece = 0; piece < 5; ++piece)
        {
            int owners = 0;
            for (int shard = 1; shard <= shards; ++shard)
                owners += header(shard, shards).has(piece) ? 1 : 0;
            EXPECT_EQ(owners, 1);
        }
        for (int shard = 1; shard <= shards; ++shard)
            all += header(shard, shards).share();
        EXPECT_EQ(all, 5u);
    }
}

TEST_F(Parts, WhatWasAddedIsReadAgain)
{
    {
        PartFile part = PartFile::openToGoOn(path, header());
        part.add(3, "three");
        part.add(0, "");
        EXPECT_THROW(PartFile::openToGoOn(path, header()), base::InputError); // in use
    }
    const PartFile part = PartFile::openToRead(path);
    EXPECT_EQ(part.numbers(), (std::vector<std::uint64_t>{0, 3}));
    EXPECT_EQ(part.read(3), "three");
    EXPECT_EQ(part.read(0), "");
    EXPECT_THROW(part.read(1), base::InputError);
    EXPECT_EQ(part.header().work, header().work);
}

// At any length and with any byte changed it has what is whole, or says what is wrong.
TEST_F(Parts, DamageIsNeverReadAsAPiece)
{
    {
        PartFile part = PartFile::openToGoOn(path, header());
        part.add(0, "first piece");
        part.add(1, "second piece");
    }
    const std::string whole = bytes();
    const auto look = [&](const std::string& content)
    {
        write(content);
        try
        {
            const PartFile part = PartFile::openToRead(path);
            EXPECT_EQ(part.header().work, header().work);
            for (const std::uint64_t piece : part.numbers())
                EXPECT_EQ(part.read(piece), piece == 0 ? "first piece" : "second piece");
            return part.pieces();
        }
        catch (const base::InputError&)
        {
            return std::uint64_t(0);
        }
    };
    EXPECT_EQ(look(whole), 2u);
    for (std::size_t size = 0; size < whole.size(); ++size)
        EXPECT_LT(look(whole.substr(0, size)), 2u) << size;
    for (std::size_t i = 0; i < whole.size(); ++i)
    {
        std::string changed = whole;
        changed[i] = static_cast<char>(changed[i] ^ 0x10);
        EXPECT_LT(look(changed), 2u) << i;
    }
}

TEST_F(Parts, DifferencesAreNamed)
{
    EXPECT_EQ(differenceOf({{"a", {{"b", 1}}}}, {{"a", {{"b", 2}}}}), "a.b is 1 and 2");
    EXPECT_EQ(differenceOf({{"a", 1}}, {{"a", 1}, {"c", 2}}), "c is not there and 2");
    EXPECT_EQ(differenceOf({{"a", 1}}, {{"a", 1}}), "");
}

} // namespace
} // namespace midair::samples

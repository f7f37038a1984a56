#include "plugin/loader/PlyCheck.h"

#include "tests/plugin/KitTest.h"
#include "tests/plugin/loader/PlyText.h"
#include "tests/plugin/loader/StockPrograms.h"

#include <osgMidair/FileFormats>

#include <algorithm>
#include <cstdint>
#include <cstring>

#include <gtest/gtest.h>

using namespace osgMidair;

// OSG's reader of PLY takes what lies beyond its memory, and ends by it or not.
TEST(PlyCheck, PlyFilesThatGoBeyondTheirVerticesAreRefused)
{
    findPlugins();
    const TemporaryFolder folder;
    EXPECT_TRUE(readModel(folder.write("good.ply", ply("3 0 2 3"))).validNode());
    const std::string more = "face 1 refers to vertex ";
    for (const auto& [indices, said] :
         {std::pair<std::string, std::string>("3 0 1 2000000000", more + "2000000000"),
          {"3 0 -900000000 3", more + "-900000000"},
          {"3 0 1 4", more + "4; the file has 4 vertices"},
          {"200 0 1", "line 15 has fewer numbers than the header announces"},
          {std::string(5000, '0'), "line 15 has more than 4094 characters"},
          {"", "line 15 has fewer numbers than the header announces"}})
        for (const bool hasNormals : {false, true})
        {
            std::string wanted = said;
            if (hasNormals && wanted.rfind("line 15", 0) == 0) wanted.replace(5, 2, "18");
            osgDB::ReaderWriter::ReadResult result =
                readModel(folder.write("broken.ply", ply(indices, hasNormals)));
            EXPECT_FALSE(result.validNode());
            EXPECT_NE(result.message().find("broken.ply: "), std::string::npos);
            EXPECT_NE(result.message().find(wanted), std::string::npos) << result.message();
        }
}

TEST(PlyCheck, BinaryPlyIsCheckedInBothOrdersOfBytes)
{
    findPlugins();
    const TemporaryFolder folder;
    for (const bool isBig : {false, true})
        for (const std::int32_t last : {3, 4, -1})
        {
            std::string text = std::string("ply\nformat binary_") + (isBig ? "big" : "little") +
                               "_endian 1.0\nelement vertex 4\nproperty float x\nproperty float "
                               "y\nproperty float z\nelement face 1\nproperty list uchar int "
                               "vertex_indices\nend_header\n";
            const auto append = [&text, isBig](const auto& value)
            {
                std::string bytes(sizeof value, '\0');
                std::memcpy(bytes.data(), &value, sizeof value);
                if (isBig) std::reverse(bytes.begin(), bytes.end());
                text += bytes;
            };
            for (const float place : {0.F, 0.F, 0.F, .1F, 0.F, 0.F, .1F, .1F, 0.F, 0.F, .1F, 0.F})
                append(place);
            text += '\3';
            for (const std::int32_t index : {0, 2, last})
                append(index);
            const std::string file = folder.write("bytes.ply", text);
            EXPECT_EQ(plyProblem(file).empty(), last == 3) << plyProblem(file);
            EXPECT_EQ(readModel(file).validNode(), last == 3) << isBig << last;
            EXPECT_EQ(plyProblem(folder.write("cut.ply", text.substr(0, text.size() - 1))),
                      "the file ends before what its header announces");
        }
}

// midair-solve against drives that an earlier build of it (g++ 12.2, Release, AVX-512) has left,
// level by level. tests/data/drives/SET/NAME.drive has, field by field, 3984 bytes of phase levels,
// then 3984 of duty levels, in the array's order; plain, avx2 and avx512 are of one binary under
// OSG_MIDAIR_SIMD. Below stands how midair-solve made each.

#include "tests/haptics/base/simd/OnEverySet.h"
#include "tests/samples/Shell.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

namespace
{

namespace fs = std::filesystem;
using namespace midair::base;

const std::string kStar = MIDAIR_ROOT "/samples/models/star.obj";
const std::string kDrives = MIDAIR_TEST_DATA "/drives/";

struct Case
{
    const char* name;
    std::string arguments;
    int fields;
};

const Case kCases[] = {{"star", kStar + " --size 0.08", 1},
                       {"sphere100", "--points-file " + kDrives + "sphere100.csv", 1},
                       {"cycle8", kStar + " --size 0.08 --cycle 8 --even 0", 8},
                       {"subsets4", kStar + " --size 0.08 --subsets 4", 4},
                       {"outline", kStar + " --size 0.08 --outline", 1}};

/// Field by field, the levels of phase and then those of duty: what the .drive files hold.
std::vector<int> levelsIn(const std::string& folder, int fields)
{
    std::vector<int> levels;
    for (int field = 1; field <= fields; ++field)
    {
        std::string name = "/drive.csv";
        if (fields > 1) name = "/drive_0" + std::to_string(field) + ".csv";
        std::ifstream file(folder + name);
        std::string line;
        std::getline(file, line);
        std::vector<int> duty;
        while (std::getline(file, line))
        {
            const std::size_t last = line.rfind(',');
            const std::size_t before = line.rfind(',', last - 1);
            levels.push_back(std::atoi(line.c_str() + before + 1));
            duty.push_back(std::atoi(line.c_str() + last + 1));
        }
        levels.insert(levels.end(), duty.begin(), duty.end());
    }
    return levels;
}

std::vector<int> storedLevels(const std::string& path)
{
    std::ifstream file(path, std::ios::binary);
    std::vector<int> levels;
    for (auto byte = std::istreambuf_iterator<char>(file); byte != std::istreambuf_iterator<char>();
         ++byte)
        levels.push_back(static_cast<unsigned char>(*byte));
    return levels;
}

/// Why sums are not added in the order of the build that the drives are from, to the last bit;
/// empty if they are.
std::string whyOnlyNear([[maybe_unused]] InstructionSet set)
{
    if (std::string(MIDAIR_SANITIZE).size() > 0) return "a sanitizer keeps loops from vectors";
#if defined(__clang__) || __GNUC__ != 12
    return "the drives are g++ 12's";
#else
    if (set != InstructionSet::PLAIN && !__builtin_cpu_is("amd"))
        return "the drives are an AMD processor's, whose estimates of 1/sqrt are its own";
    return "";
#endif
}

class StoredDrives : public testing::TestWithParam<std::tuple<InstructionSet, int>>
{
};

} // namespace

TEST_P(StoredDrives, AreMadeAgainToTheLastLevel)
{
    const InstructionSet set = std::get<0>(GetParam());
    const Case& of = kCases[std::get<1>(GetParam())];
    const std::string name = instructionSetName(set);
    if (!isRunnable(set)) GTEST_SKIP() << "this processor has no " << name;
    const std::string why = whyOnlyNear(set);
    if (!why.empty() && std::string(of.name) == "outline")
        GTEST_SKIP() << why << ", and the outline's descent shows each bit";

    const std::string out = testing::TempDir() + "midair-stored-" + name + "-" + of.name;
    fs::remove_all(out);
    const Outcome run = shell("OSG_MIDAIR_SIMD=" + name + " " MIDAIR_BIN "/midair-solve " +
                              of.arguments + " --out " + out);
    ASSERT_EQ(run.code, 0) << run.output;
    ASSERT_EQ(run.output.find("OSG_MIDAIR_SIMD"), std::string::npos) << run.output;
    const std::vector<int> levels = levelsIn(out, of.fields);
    const std::vector<int> stored = storedLevels(kDrives + name + "/" + of.name + ".drive");
    ASSERT_EQ(stored.size(), 2U * 3984U * static_cast<std::size_t>(of.fields));
    ASSERT_EQ(levels.size(), stored.size());

    int different = 0, largest = 0;
    for (std::size_t i = 0; i < stored.size(); ++i)
    {
        const int step = std::abs(levels[i] - stored[i]);
        different += step != 0 ? 1 : 0;
        largest = std::max(largest, std::min(step, 256 - step)); // phases go round
    }
    if (why.empty())
        EXPECT_EQ(different, 0) << "of " << stored.size() << " levels, by up to " << largest;
    else // the same field: shaped rounding takes other levels near the wanted phases
    {
        // Between the three instruction sets a third at most, by 4.
        EXPECT_LE(different, static_cast<int>(stored.size() / 2)) << why;
        EXPECT_LE(largest, 6) << why;
    }
}

INSTANTIATE_TEST_SUITE_P(OfAllSets,
                         StoredDrives,
                         testing::Combine(testing::ValuesIn(kInstructionSets),
                                          testing::Range(0, 5)),
                         [](const testing::TestParamInfo<StoredDrives::ParamType>& info)
                         {
                             return std::string(instructionSetName(std::get<0>(info.param))) + "_" +
                                    kCases[std::get<1>(info.param)].name;
                         });

TEST(SolveProgram, AnInstructionSetThatIsUnknownIsToldAndIgnored)
{
    const std::string out = testing::TempDir() + "midair-stored-unknown";
    const Outcome run = shell("OSG_MIDAIR_SIMD=neon " MIDAIR_BIN "/midair-solve " + kStar +
                              " --size 0.08 --out " + out);
    EXPECT_EQ(run.code, 0) << run.output;
    const std::string told = "OSG_MIDAIR_SIMD is 'neon', it must be plain, avx2 or avx512";
    const std::size_t first = run.output.find(told);
    ASSERT_NE(first, std::string::npos) << run.output;
    EXPECT_EQ(run.output.find(told, first + 1), std::string::npos) << "told twice: " << run.output;
}

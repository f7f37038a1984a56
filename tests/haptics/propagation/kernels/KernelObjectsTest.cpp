// What the linker sees of the kernels.
#include <array>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

namespace
{

std::string outputOf(const std::string& command)
{
    std::string output;
    FILE* pipe = popen(command.c_str(), "r");
    if (!pipe) return output;
    std::array<char, 4096> buffer{};
    while (const std::size_t got = fread(buffer.data(), 1, buffer.size(), pipe))
        output.append(buffer.data(), got);
    return pclose(pipe) == 0 ? output : "";
}

} // namespace

// A function that is defined in several objects (inline, or of a template) is kept once, by the
// order of linking: if that were one that is compiled for AVX-512, the program would end on a
// processor without, wherever it's called.
TEST(KernelObjects, DefineNothingThatTheLinkerMayShare)
{
    std::ifstream list(MIDAIR_KERNEL_OBJECTS);
    std::map<std::string, int> functions; // by instruction set
    for (std::string object; std::getline(list, object);)
    {
        if (object.empty()) continue;
        const std::string symbols =
            outputOf(MIDAIR_NM " --defined-only --demangle '" + object + "'");
        if (symbols.empty()) continue; // an object that is empty for its set; see the count below
        std::string set = "plain";
        for (const char* other : {"avx2", "avx512"})
            if (object.find("_" + std::string(other) + ".dir") != std::string::npos) set = other;
        std::istringstream lines(symbols);
        for (std::string line; std::getline(lines, line);)
        {
            std::istringstream cells(line);
            std::string address, name;
            char kind = '?';
            cells >> address >> kind;
            std::getline(cells >> std::ws, name);
            EXPECT_EQ(std::string("WwVvuCi").find(kind), std::string::npos)
                << object << ": " << line;
            // Small letters are for what no other object sees.
            if (kind < 'A' || kind > 'Z') continue;
            EXPECT_NE(name.find("::" + set + "::"), std::string::npos) << object << ": " << line;
            ++functions[set];
        }
    }
    EXPECT_GE(functions["plain"], 29) << "does " MIDAIR_NM " run?";
    for (const auto& [set, count] : functions)
        EXPECT_EQ(count, functions["plain"]) << set;
#ifdef MIDAIR_HAS_SIMD
    EXPECT_EQ(functions.size(), 3U);
#endif
}

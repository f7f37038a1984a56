// Runs the built program as a user would.

#include <array>
#include <cstdio>
#include <string>

#include <gtest/gtest.h>
#include <sys/wait.h>

TEST(HandsSample, TellsTouchesAndWhatIsSolved)
{
    FILE* pipe = popen(MIDAIR_BIN "/hands 2>&1", "r");
    ASSERT_TRUE(pipe);
    std::string output;
    std::array<char, 4096> buffer{};
    while (const std::size_t got = fread(buffer.data(), 1, buffer.size(), pipe))
        output.append(buffer.data(), got);
    const int status = pclose(pipe);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << output;
    // What depends on simulation time alone; how many fields were solved in it depends on the
    // machine.
    EXPECT_NE(output.find(" 0.42 s  enter box with the bone index distal to index tip of hand 1: "
                          "-0.4 mm, 16 mm^2"),
              std::string::npos)
        << output;
    EXPECT_NE(output.find(" s  leave box with"), std::string::npos) << output;
    EXPECT_NE(output.find(" 1.25 s  box at x = 12.5 mm: "), std::string::npos) << output;
    EXPECT_NE(output.find("120 frames, "), std::string::npos) << output;
}

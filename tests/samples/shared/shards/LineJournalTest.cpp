#include "samples/shared/shards/LineJournal.h"

#include "haptics/base/InputError.h"

#include <atomic>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <unistd.h>

using midair::base::InputError;
using midair::samples::LineJournal;

namespace
{

const std::string kPath =
    testing::TempDir() + "midair-journal-" + std::to_string(::getpid()) + ".csv";

} // namespace

TEST(LineJournal, KeepsWhatWasWrittenAndOneRunHasIt)
{
    std::filesystem::remove(kPath);
    {
        LineJournal journal(kPath, "answers");
        journal.replace("head\n");
        journal.append("1\n2");
        EXPECT_THROW(LineJournal(kPath, "answers"), InputError);
    }
    LineJournal next(kPath, "answers");
    EXPECT_EQ(next.text(), "head\n1\n2");
    EXPECT_EQ(next.tornLine(), "2");
    next.cutTornLine();
    EXPECT_EQ(next.text(), "head\n1\n");
    std::filesystem::remove(kPath);
}

// Each of them begins a file that isn't there, as two runs do that a visitor started by two clicks:
// who has it writes into the file that is found by its name.
TEST(LineJournal, OfRunsThatBeginAtOnceOneHasTheFile)
{
    for (int round = 0; round < 300; ++round)
    {
        std::filesystem::remove(kPath);
        std::atomic<int> tried{0};
        std::atomic<int> owners{0};
        const auto run = [&]
        {
            std::unique_ptr<LineJournal> journal;
            try
            {
                journal = std::make_unique<LineJournal>(kPath, "answers");
                if (journal->text().empty()) journal->replace("head\n");
                ++owners;
            }
            catch (const InputError&)
            {
                journal = nullptr; // another has it
            }
            ++tried;
            while (tried < 3)
                std::this_thread::yield();
            if (journal) journal->append("answer\n");
        };
        std::thread second(run);
        std::thread third(run);
        run();
        second.join();
        third.join();
        ASSERT_EQ(owners, 1) << "in round " << round;
        std::ifstream file(kPath);
        const std::string text(std::istreambuf_iterator<char>(file), {});
        ASSERT_EQ(text, "head\nanswer\n") << "in round " << round;
    }
    std::filesystem::remove(kPath);
}

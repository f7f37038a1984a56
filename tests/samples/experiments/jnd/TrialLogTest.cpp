#include "samples/experiments/jnd/TrialFile.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

using namespace midair::samples;

namespace
{

namespace fs = std::filesystem;

/// A folder of its own, with results of three trials.
class TrialLogs : public testing::Test
{
public:
    TrialLogs() : folder(testing::TempDir() + "midair-jnd-" + std::to_string(::getpid()))
    {
        fs::remove_all(folder);
        fs::create_directories(folder);
        head.experiment = lineExperiment("oblique");
        head.participant = "P07";
        head.staircase = {45.0, 2.5, 3};
        head.others = {{"array", "octagon"}, {"line_s", 4.0}};
        path = folder + "/results.csv";
        TrialLog log(path, head);
        for (const bool isFelt : {true, true, true})
            log.add(isFelt, figures());
        whole = text();
    }
    ~TrialLogs() override { fs::remove_all(folder); }

    static Trial figures()
    {
        Trial trial;
        trial.answer_s = 1.25;
        trial.line_s = 1.0;
        trial.rms = 0.00012;
        trial.loudness = 1.02;
        trial.level_Pa = 1500.0;
        return trial;
    }
    std::string text() const
    {
        std::ifstream in(path, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    }
    void write(const std::string& content) const
    {
        std::ofstream(path, std::ios::binary) << content;
    }
    /// What opening the file is refused with; empty: it isn't.
    std::string refusal() const
    {
        try
        {
            const TrialLog log(path, head);
        }
        catch (const std::runtime_error& error)
        {
            return error.what();
        }
        return {};
    }
    void expectRefused(const std::string& why) const
    {
        const std::string before = text();
        EXPECT_NE(refusal().find(why), std::string::npos) << refusal();
        EXPECT_EQ(text(), before) << "it has to stay as it is";
    }

    std::string folder, path, whole;
    SessionHead head;
};

} // namespace

TEST_F(TrialLogs, SayWhatTheyAreOf)
{
    EXPECT_EQ(whole,
              "# midair-jnd 1\n"
              "# {\"array\":\"octagon\",\"experiment\":\"oblique\",\"line_s\":4.0,"
              "\"maximum\":45.0,\"participant\":\"P07\",\"step\":2.5,\"times\":3}\n"
              "trial,run,direction,value_deg,answer,answer_s,line_s,rms,loudness,level_Pa\n"
              "1,1,down,45,yes,1.250,1.000,0.00012,1.02,1500\n"
              "2,1,down,42.5,yes,1.250,1.000,0.00012,1.02,1500\n"
              "3,1,down,40,yes,1.250,1.000,0.00012,1.02,1500\n");
    struct stat about = {};
    ASSERT_EQ(::stat(path.c_str(), &about), 0);
    EXPECT_EQ(about.st_mode & 0777, 0600u) << "nobody else reads answers";
}

TEST_F(TrialLogs, GoOn)
{
    TrialLog log(path, head);
    EXPECT_EQ(log.dropped(), "");
    ASSERT_EQ(log.results().trials.size(), 3u);
    EXPECT_DOUBLE_EQ(log.results().trials[1].value, 42.5);
    EXPECT_DOUBLE_EQ(log.results().trials[1].rms, 0.00012);
    EXPECT_DOUBLE_EQ(log.results().staircase.value(), 37.5);
    log.addVoid("the array\nis muted");
    log.add(false, figures());
    EXPECT_EQ(text(),
              whole + "# void trial 4 doesn't count: the array is muted\n"
                      "4,1,down,37.5,no,1.250,1.000,0.00012,1.02,1500\n");
    const TrialFile read = TrialFile::load(path);
    EXPECT_EQ(read.trials.size(), 4u);
    ASSERT_EQ(read.voided.size(), 1u);
    EXPECT_EQ(read.staircase.run(), 2);
}

TEST_F(TrialLogs, GoOnAfterACutAnywhere)
{
    const std::size_t begin = headText(head).size();
    for (std::size_t cut = 0; cut <= whole.size(); ++cut)
    {
        SCOPED_TRACE(cut);
        write(whole.substr(0, cut));
        std::size_t found = 0;
        {
            const TrialLog log(path, head);
            found = log.results().trials.size();
            const bool isTorn = cut > 0 && whole[cut - 1] != '\n';
            const bool isHead = cut > 0 && cut < begin;
            EXPECT_EQ(!log.dropped().empty(), isTorn || isHead) << log.dropped();
        }
        TrialLog log(path, head);
        EXPECT_EQ(log.dropped(), "");
        while (log.results().trials.size() < 3)
            log.add(true, figures());
        EXPECT_EQ(text(), whole);
        EXPECT_LE(found, 3u);
        EXPECT_EQ(found,
                  cut < begin ? 0
                              : std::size_t(std::count(whole.begin() + static_cast<long>(begin),
                                                       whole.begin() + static_cast<long>(cut),
                                                       '\n')));
    }
}

TEST_F(TrialLogs, ToldWhatWasDropped)
{
    write(whole + "4,1,down,37");
    const TrialLog log(path, head);
    EXPECT_NE(log.dropped().find("\"4,1,down,37\""), std::string::npos) << log.dropped();
}

TEST_F(TrialLogs, RefuseOtherSessionsByName)
{
    head.participant = "P08";
    expectRefused("participant is \"P07\" and \"P08\"");
    head.participant = "P07";
    head.others["line_s"] = 2.0;
    expectRefused("line_s is 4.0 and 2.0");
    head.others["line_s"] = 4.0;
    head.staircase.step = 5.0;
    expectRefused("step is 2.5 and 5.0");
    head.staircase.step = 2.5;
    head.experiment = lineExperiment("shifted");
    head.staircase = {27.0, 1.5, 3};
    expectRefused("experiment is \"oblique\" and \"shifted\"");
}

TEST_F(TrialLogs, RefuseWhatTheyDidNotWrite)
{
    write("my diary\nis long enough not to be taken for the beginning of a head, surely, since it "
          "goes on and on and on and on and on and on and on and on and on and on and on\n");
    expectRefused("line 1: isn't \"# midair-jnd 1\"");
    write("my diary");
    expectRefused("line 1");
    write(whole + "5,1,down,37.5,yes,1,1,0,1,1500\n");
    expectRefused("line 7: is trial 5 of run 1 at 37.5, where the staircase asks for trial 4 of "
                  "run 1 at 37.5");
    write(whole + "4,1,down,35,yes,1,1,0,1,1500\n");
    expectRefused("line 7");
    write(whole + "4,1,down,37.5,perhaps,1,1,0,1,1500\n");
    expectRefused("line 7: \"4,1,down,37.5,perhaps,1,1,0,1,1500\" isn't a trial");
    write(whole + "4,1,down,37.5,yes,1,1,nan,1,1500\n");
    expectRefused("line 7");
    write(whole + "\n");
    expectRefused("line 7");
}

TEST_F(TrialLogs, AreWrittenByOneRunAtATime)
{
    const TrialLog log(path, head);
    EXPECT_NE(refusal().find("are being written by another run"), std::string::npos) << refusal();
}

TEST_F(TrialLogs, HaveNoTrialAfterTheLast)
{
    {
        TrialLog log(path, head);
        while (!log.results().staircase.isFinished())
            log.add(log.results().staircase.value() > 20.0, figures());
    }
    EXPECT_TRUE(TrialFile::load(path).staircase.isFinished());
    write(text() + "99,7,down,20,yes,1,1,0,1,1500\n");
    expectRefused("follows the last trial");
}

TEST(ParticipantCode, IsNoName)
{
    for (const char* code : {"P07", "A1", "ABC1234"})
        EXPECT_EQ(problemOfCode(code), "");
    for (const char* name :
         {"Anna", "", "P", "07", "ABCD1", "P12345", "P07 ", "p07", "P07,x", "../P7"})
        EXPECT_NE(problemOfCode(name), "") << name;
}

// An installation whose frames hang is silenced by its hold, and ends when it is told to.
#include "device/recording/Recording.h"
#include "samples/installations/shell/Installation.h"
#include "samples/installations/shell/MuteMemory.h"
#include "tests/Emulator.h"
#include "tests/Eventually.h"
#include "tests/samples/Ending.h"
#include "tests/samples/installations/Run.h"

#include <osgMidair/HapticSurface>

#include <osg/MatrixTransform>
#include <osg/Shape>
#include <osg/ShapeDrawable>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <iterator>
#include <utility>
#include <vector>

#include <spawn.h>
#include <sys/ptrace.h>
#include <sys/wait.h>

using namespace midair::samples;

namespace
{

/// A box that plays, whether somebody is there or not, until a frame hangs.
class Hanging : public Installation
{
public:
    /// \a gone: folder that is removed before; what is said on stderr then goes to \a to. Empty:
    /// none.
    explicit Hanging(int to, std::string gone = {}) : _to(to), _gone(std::move(gone)) {}
    InstallationTitle title() const override { return {"hanging", "A test.", "Nobody"}; }
    std::string arrayOf(const std::string&) const override { return "board"; }
    void build(Stage& stage) override
    {
        osg::ref_ptr<osg::MatrixTransform> at =
            new osg::MatrixTransform(osg::Matrixd::translate(0.0, 0.0, 0.15));
        at->addChild(
            new osgMidair::HapticSurface(new osg::ShapeDrawable(new osg::Box(osg::Vec3(), 0.04F))));
        stage.haptics.addChild(at);
    }
    void update(const Moment& now) override
    {
        if (now.statistics.state != osgMidair::ArrayState::PLAYING) return;
        if (!_gone.empty()) std::filesystem::remove_all(_gone);
        if (!_gone.empty()) ::dup2(_to, STDERR_FILENO);
        EXPECT_EQ(::write(_to, "r", 1), 1);
        for (;;)
            ::pause();
    }
    bool restsAlone() const override { return false; }
    void report(nlohmann::ordered_json&) const override {}

private:
    const int _to;
    const std::string _gone;
};

/// Ends an installation by a signal while its frame hangs.
Ending endingOfHung(const std::string& device, const std::string& state, const std::string& gone)
{
    return endingOf(
        [&](int to)
        {
            Hanging installation(to, gone);
            // The hold is longer than it may take, so it isn't what silences it.
            std::string words[] = {"midair-hanging",
                                   "--headless",
                                   "--pictures",
                                   "0",
                                   "--frames",
                                   "100000",
                                   "--out",
                                   std::filesystem::temp_directory_path().string(),
                                   "--state",
                                   state,
                                   "--device",
                                   device,
                                   "--set",
                                   "earLimit=none"};
            std::vector<char*> line;
            for (std::string& word : words)
                line.push_back(word.data());
            return runInstallation(installation, static_cast<int>(line.size()), line.data());
        },
        SIGTERM);
}

namespace recording = midair::device::recording;

double realTime_s()
{
    return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch())
        .count();
}

/// What is in a recording by now, with times on realTime_s(); empty if it isn't there yet.
struct Show
{
    struct Entry
    {
        double time_s = 0.0;
        bool sounds = false;
    };
    std::vector<Entry> entries;

    explicit Show(const std::string& file)
    {
        std::ifstream in(file, std::ios::binary);
        const std::string bytes{std::istreambuf_iterator<char>(in), {}};
        if (bytes.size() < recording::kHeaderBytes) return;
        std::uint64_t start_ns = 0;
        std::memcpy(&start_ns, bytes.data() + 16, sizeof start_ns); // as Recording.h has it
        recording::Reader reader(bytes, file);
        recording::Entry entry;
        while (reader.next(entry) == recording::Stop::MORE)
        {
            const auto& duty = entry.signal.duty;
            const bool sounds =
                entry.kind == recording::Kind::FIELD &&
                std::any_of(duty.begin(), duty.end(), [](std::uint8_t level) { return level > 0; });
            entries.push_back({static_cast<double>(start_ns + entry.time_ns) * 1e-9, sounds});
        }
    }
    int soundingBetween(double begin_s, double end_s) const
    {
        return static_cast<int>(std::count_if(entries.begin(),
                                              entries.end(),
                                              [&](const Entry& one) {
                                                  return one.sounds && one.time_s > begin_s &&
                                                         one.time_s <= end_s;
                                              }));
    }
    double lastSound_s() const
    {
        double last_s = 0.0;
        for (const Entry& one : entries)
            if (one.sounds) last_s = one.time_s;
        return last_s;
    }
};

/// An installation as a user starts it, whose main thread alone can be stopped.
class Started
{
public:
    explicit Started(std::vector<std::string> words)
    {
        words.front() = std::string(MIDAIR_BIN) + "/" + words.front();
        std::vector<char*> line;
        for (std::string& word : words)
            line.push_back(word.data());
        line.push_back(nullptr);
        if (::posix_spawn(&_pid, line[0], nullptr, nullptr, line.data(), environ) != 0) _pid = 0;
    }
    ~Started()
    {
        if (_pid <= 0) return;
        ::kill(_pid, SIGKILL);
        ::waitpid(_pid, nullptr, __WALL);
    }
    Started(const Started&) = delete;
    Started& operator=(const Started&) = delete;

    /// Of a process that is traced, one thread can be stopped; returns 0, or what errno says.
    int hang()
    {
        if (_pid <= 0) return ESRCH;
        if (::ptrace(PTRACE_SEIZE, _pid, nullptr, nullptr) != 0) return errno;
        if (::ptrace(PTRACE_INTERRUPT, _pid, nullptr, nullptr) != 0) return errno;
        return ::waitpid(_pid, nullptr, __WALL) == _pid ? 0 : errno;
    }

private:
    pid_t _pid = 0;
};

constexpr double kHold_s = 1.0;  ///< that installations add by themselves
constexpr double kLate_s = 0.05; ///< the promise, as in HoldMatrixTest

/// Watches for \a duration_s; returns the longest that this thread didn't run.
double longestGap_s(double duration_s)
{
    double gap_s = 0.0;
    const double begin_s = realTime_s();
    for (double look_s = begin_s; look_s < begin_s + duration_s;)
    {
        letPass(5e-4);
        gap_s = std::max(gap_s, realTime_s() - look_s);
        look_s = realTime_s();
    }
    return gap_s;
}

/// An installation, and what makes it play fields in turn by a thread of their own.
using Playing = std::pair<const char*, std::vector<std::string>>;

class InstallationInTurn : public testing::TestWithParam<Playing>
{
};

std::string nameOf(const testing::TestParamInfo<Playing>& info)
{
    return info.param.first;
}

} // namespace

// Nothing but its main thread stands still; fields go on in turn, and are no sign of life.
TEST_P(InstallationInTurn, IsSilentAfterItsHoldWithItsMainThreadHung)
{
    if (emulatorOfTests() != nullptr) GTEST_SKIP() << "no thread alone can be stopped there";
    const auto& [name, more] = GetParam();
    const OwnFolder folder(std::string("hung-") + name);
    const std::string file = folder.path + "/show.recording";
    std::vector<std::string> words = {std::string("midair-") + name,
                                      "--headless",
                                      "--pictures",
                                      "0",
                                      "--frames",
                                      "100000",
                                      "--out",
                                      folder.path,
                                      "--array",
                                      "autd3",
                                      "--device",
                                      "record:" + file,
                                      "--set",
                                      "earLimit=none"};
    words.insert(words.end(), more.begin(), more.end());
    Started program(words);
    const auto playsInTurn = [&]
    { return Show(file).soundingBetween(realTime_s() - 0.3, realTime_s()) > 60; };
    ASSERT_TRUE(eventually(playsInTurn)) << "it doesn't play";
    const int error = program.hang();
    if (error == EPERM) GTEST_SKIP() << "no process may be traced here";
    ASSERT_EQ(error, 0) << std::strerror(error);
    const double hung_s = realTime_s();
    const double gap_s = longestGap_s(kHold_s + 1.0);
    const Show show(file);
    EXPECT_GT(show.soundingBetween(hung_s + 0.1, hung_s + 0.6), 50) << "its other threads play on";
    EXPECT_LT(show.lastSound_s(), hung_s + kHold_s + kLate_s + gap_s)
        << "sounds " << 1e3 * (show.lastSound_s() - hung_s) << " ms after it hung, seen every "
        << 1e3 * gap_s << " ms";
    ASSERT_FALSE(show.entries.empty());
    EXPECT_FALSE(show.entries.back().sounds);
}

// Water in contact would fall silent as its hands are no news.
INSTANTIATE_TEST_SUITE_P(
    Programs,
    InstallationInTurn,
    testing::Values(Playing{"piano", {"--set", "calibration=1 0 0 0 0 1 0 0 0 0 1 0 0 0 0.15 1"}},
                    Playing{"water",
                            {"--set",
                             "calibration=1 0 0 0 0 1 0 0 0 0 1 0 0 0 0.15 1",
                             "--set",
                             "render=object",
                             "--set",
                             "cycle=4"}}),
    nameOf);

TEST(InstallationThatHangs, EndsBySigtermSilentFirst)
{
    const OwnFolder folder("hanging");
    const std::string file = folder.path + "/show.recording";
    const Ending ending =
        endingOfHung("record:" + file + "?hold=30s", folder.path + "/state.json", {});
    EXPECT_EQ(ending.signal, SIGTERM);
    EXPECT_LT(ending.seconds, 15.0) << "it was the hold's end that silenced it";
    std::ifstream in(file, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    recording::Reader reader(bytes, file);
    recording::Entry entry;
    std::vector<recording::Kind> kinds;
    while (reader.next(entry) == recording::Stop::MORE)
        kinds.push_back(entry.kind);
    ASSERT_GE(kinds.size(), 2U);
    EXPECT_EQ(kinds.front(), recording::Kind::FIELD);
    EXPECT_EQ(kinds.back(), recording::Kind::SILENCE);
    const MuteMemory next(folder.path + "/state.json", 0.0);
    EXPECT_FALSE(next.startsMuted());
    EXPECT_EQ(next.crashes(), 0) << "who is asked to end has not crashed";
}

TEST(InstallationThatHangs, SaysOnceThatItsStateCantBeWritten)
{
    const OwnFolder folder("unwritten");
    const std::string gone = folder.path + "/gone";
    std::filesystem::create_directories(gone);
    const std::string state = gone + "/state.json";
    const Ending ending = endingOfHung("sim:?hold=30s", state, gone);
    EXPECT_EQ(ending.signal, SIGTERM);
    const std::size_t first = ending.said.find("\"" + state + "\"");
    ASSERT_NE(first, std::string::npos) << ending.said;
    EXPECT_EQ(ending.said.find(state, first + state.size()), std::string::npos) << ending.said;
}

// Runs the built program as a user would: plan, run and fit against a rehearsed instrument.
#include "device/recording/Recording.h"
#include "haptics/array/Reflector.h"
#include "haptics/array/TransducerArray.h"
#include "tests/device/limits/UserCapTexts.h"
#include "tests/samples/Shell.h"

#include <cmath>
#include <complex>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

namespace
{

namespace fs = std::filesystem;
using midair::haptics::TransducerArray;

const std::string kTune = MIDAIR_BIN "/midair-tune";

/// A folder of the test's own, gone at its end, with a plan for a board.
class MidairTune : public testing::Test
{
public:
    MidairTune() : folder(testing::TempDir() + "midair-tune-" + std::to_string(::getpid()))
    {
        fs::remove_all(folder);
        fs::create_directories(folder);
        plan("--mic 0.004 0.002 0.15");
    }
    ~MidairTune() override { fs::remove_all(folder); }

    Outcome tune(const std::string& arguments) const
    {
        return shell("cd " + folder + " && " + kTune + " " + arguments);
    }
    void plan(const std::string& arguments) const
    {
        const Outcome made = tune("plan --array " + array + " " + arguments);
        ASSERT_EQ(made.code, 0) << made.output;
    }
    std::string instrument(const std::string& options = "") const
    {
        return " --readings 'exec:" + kTune + " rehearse --plan plan.csv --array " + array +
               " --serve " + options + "'";
    }
    std::string run(const std::string& device = "sim:") const
    {
        return "run --array " + array + " --settle 0 --integrate 0 --quiet --device '" + device +
               "'";
    }
    std::string text(const std::string& name) const
    {
        std::ifstream in(folder + "/" + name, std::ios::binary);
        return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    }
    void write(const std::string& name, const std::string& content) const
    {
        std::ofstream(folder + "/" + name, std::ios::binary) << content;
    }
    /// Rows of readings.csv, with the number of their readings.
    std::multiset<int> rows() const
    {
        std::multiset<int> rows;
        std::istringstream lines(text("readings.csv"));
        for (std::string line; std::getline(lines, line);)
            if (line[0] != '#') rows.insert(std::stoi(line));
        return rows;
    }
    void expectComplete(int count) const
    {
        const std::multiset<int> read = rows();
        EXPECT_EQ(read.size(), std::size_t(count));
        for (int row = 0; row < count; ++row)
            EXPECT_EQ(read.count(row), 1u) << row;
    }

    const std::string folder;
    std::string array = "board";
    static constexpr int kRows = 16 + 249;
};

bool says(const Outcome& outcome, const std::string& what)
{
    return outcome.output.find(what) != std::string::npos;
}

/// The rms difference of phases, degrees, but for a common one, of transducers that play in both.
double differenceOf(const TransducerArray& a, const TransducerArray& b)
{
    std::complex<double> common = 0.0;
    for (int i = 0; i < a.size(); ++i)
        if (a.gain[i] * b.gain[i] > 0.0)
            common += std::polar(1.0, a.phaseOffset_rad[i] - b.phaseOffset_rad[i]);
    double squares = 0.0;
    int count = 0;
    for (int i = 0; i < a.size(); ++i)
        if (a.gain[i] * b.gain[i] > 0.0)
        {
            const double error = std::arg(
                std::polar(1.0, a.phaseOffset_rad[i] - b.phaseOffset_rad[i]) * std::conj(common));
            squares += error * error;
            ++count;
        }
    return std::sqrt(squares / count) * 57.29578;
}

} // namespace

TEST_F(MidairTune, finds_what_the_rehearsal_hides)
{
    for (const std::string method : {"single", "hadamard", "levels"})
    {
        SCOPED_TRACE(method);
        fs::remove(folder + "/readings.csv");
        plan("--mic 0.004 0.002 0.15 --mic 0.05 -0.01 0.17 --method " + method);
        const Outcome played =
            tune(run() + instrument("--seed 4 --dead 0.02 --truth truth.json") + " --all-places");
        ASSERT_EQ(played.code, 0) << played.output;
        const Outcome fitted = tune("fit --array board --out tuned.json");
        ASSERT_EQ(fitted.code, 0) << fitted.output;
        EXPECT_TRUE(says(fitted, "known up to a shift of the whole field")) << fitted.output;
        const TransducerArray tuned = TransducerArray::load(folder + "/tuned.json");
        const TransducerArray truth = TransducerArray::load(folder + "/truth.json");
        EXPECT_LT(differenceOf(tuned, truth), 5.0);
        EXPECT_EQ(tuned.dead, truth.dead);
        const std::string picture = text("tuned.svg");
        for (const char* said : {"<svg xmlns", " of 249 transducers play, ", "facing (0, 0, 1)"})
            EXPECT_NE(picture.find(said), std::string::npos) << said;
    }
}

TEST_F(MidairTune, checks_foci_afterwards)
{
    ASSERT_EQ(tune(run() + instrument()).code, 0);
    ASSERT_EQ(tune("fit --array board --out tuned.json").code, 0);
    for (const auto& [made, code, verdict] :
         {std::tuple("tuned.json", 0, "passed      "), std::tuple("board", 1, "failed      ")})
    {
        const std::string of = made;
        ASSERT_EQ(
            tune("plan --method focus --temperature 21 --mic 0.004 0.002 0.15 --out focus.csv "
                 "--array " +
                 of)
                .code,
            0);
        const Outcome lines = tune("rehearse --plan focus.csv --array board --tuned " + of +
                                   " --reflections -30 > lines");
        ASSERT_EQ(lines.code, 0) << lines.output;
        const Outcome played = tune("run --plan focus.csv --settle 0 --integrate 0 --device sim: "
                                    "--readings lines --out focus-readings.csv --array " +
                                    of);
        ASSERT_EQ(played.code, 0) << played.output;
        EXPECT_TRUE(says(played, "100 % of 163 rows")) << played.output;
        const Outcome checked =
            tune("check --plan focus.csv --readings focus-readings.csv --array " + of);
        EXPECT_EQ(checked.code, code) << checked.output;
        EXPECT_TRUE(says(checked, verdict)) << checked.output;
        fs::remove(folder + "/focus-readings.csv");
    }
}

// The array is tuned without the plate; the same seed hides the same errors with it.
TEST_F(MidairTune, finds_a_plate_that_reflects)
{
    plan("--mic 0.01 -0.02 0.12 --mic 0.03 0.03 0.13 --mic -0.02 0.01 0.11 --method hadamard");
    const std::string hidden = "--seed 6 --reflections -30";
    ASSERT_EQ(tune(run() + instrument(hidden) + " --all-places").code, 0);
    ASSERT_EQ(tune("fit --array board --out tuned.json").code, 0);
    fs::remove(folder + "/readings.csv");
    TransducerArray with = TransducerArray::singleBoard();
    midair::haptics::Reflector plate;
    plate.position = {0.0, 0.0, 0.21};
    plate.reflection = 0.9;
    plate.accuracy_mm = 1.0;
    with.reflectors = {plate};
    with.save(folder + "/with.json");
    const std::string from = " --readings 'exec:" + kTune +
                             " rehearse --plan plan.csv --array with.json --serve " + hidden + "'";
    ASSERT_EQ(tune(run() + from + " --all-places").code, 0);
    plate.position.z() = 0.2125;
    plate.reflection = 1.0;
    const std::string one = midair::haptics::reflectorsToJson({plate});
    write("guess.json", "{\"reflectors\": " + one + "}");
    const Outcome fitted = tune("reflector --array tuned.json --guess guess.json --out found.json");
    ASSERT_EQ(fitted.code, 0) << fitted.output;
    EXPECT_TRUE(says(fitted, "fields are corrected for it")) << fitted.output;
    const auto found = midair::haptics::reflectorsFromJson(text("found.json"), "found.json");
    ASSERT_EQ(found.size(), 1u);
    EXPECT_NEAR(found[0].position.z(), 0.21, 0.3e-3);
    EXPECT_NEAR(std::fabs(found[0].normal.z()), 1.0, 2e-6);
    EXPECT_NEAR(found[0].reflection, 0.9, 0.03);

    write("guess.json",
          "{\"reflectors\": " +
              midair::haptics::reflectorsToJson({plate, midair::haptics::Reflector(plate)}) + "}");
    const Outcome two = tune("reflector --array tuned.json --guess guess.json");
    EXPECT_EQ(two.code, 2) << two.output;
    EXPECT_TRUE(says(two, "has 2 reflectors")) << two.output;

    write("touched.csv", "x_m,y_m,z_m\n-1,-1,0.2125\n1,-1,0.2125\n1,1,0.2125\n-1,1,0.2125\n");
    const Outcome touched =
        tune("reflector --array tuned.json --guess touched.csv --out found.json");
    ASSERT_EQ(touched.code, 0) << touched.output;
    EXPECT_TRUE(says(touched, "4 places, 0.00 mm rms off the plane of a plate of 2000 x 2000 mm"));
    const auto again = midair::haptics::reflectorsFromJson(text("found.json"), "found.json");
    EXPECT_NEAR(again.at(0).position.z(), 0.21, 0.3e-3);
    EXPECT_NEAR(again.at(0).reflection, 0.9, 0.03);
    write("display.json",
          R"({"screen": {"lowerLeft_m": [-1, -1, 0.2125], "lowerRight_m": [1, -1, 0.2125],
              "upperLeft_m": [-1, 1, 0.2125], "pixels": [1920, 1080]},
    "eye": "fixed 0 0 1"})");
    const Outcome shown =
        tune("reflector --array tuned.json --guess display.json --out again.json");
    ASSERT_EQ(shown.code, 0) << shown.output;
    EXPECT_EQ(text("again.json"), text("found.json")) << "the same corners";
    write("touched.csv", "0,0,0.2\n0.1,0,0.2\n0.2,0,0.2\n");
    const Outcome few = tune("reflector --array tuned.json --guess touched.csv");
    EXPECT_EQ(few.code, 2) << few.output;
    EXPECT_TRUE(says(few, "3 places were touched; a plate needs its four corners")) << few.output;
}

TEST_F(MidairTune, goes_on_where_it_was_killed)
{
    const Outcome killed = shell(
        "cd " + folder + " && timeout -s KILL 0.6 " + kTune +
        " run --array board --settle 1ms --integrate 2ms --quiet --device sim:" + instrument());
    EXPECT_EQ(killed.code, 137) << killed.output;
    const std::size_t before = rows().size();
    ASSERT_GT(before, 5u);
    ASSERT_LT(before, std::size_t(kRows));
    write("readings.csv", text("readings.csv") + "200,0.1234"); // as a power failure may leave it
    const Outcome on =
        tune("run --array board --settle 0 --integrate 0 --device sim:" + instrument());
    EXPECT_EQ(on.code, 0) << on.output;
    EXPECT_TRUE(says(on, "the last line has no end and is left out")) << on.output;
    expectComplete(kRows);
    const Outcome once = tune(run() + " --readings /dev/null");
    EXPECT_EQ(once.code, 0) << "there was nothing left to read: " << once.output;
    EXPECT_EQ(tune("fit --array board").code, 0);
}

TEST_F(MidairTune, stops_for_the_microphone_to_be_moved)
{
    plan("--mic 0.004 0.002 0.15 --mic 0.05 -0.01 0.17");
    const Outcome first = tune(run() + instrument());
    EXPECT_EQ(first.code, 1) << first.output;
    EXPECT_TRUE(says(first, "Move the microphone to place 1, (0.0500, -0.0100, 0.1700) m"));
    EXPECT_EQ(rows().size(), std::size_t(kRows));
    EXPECT_EQ(tune(run() + instrument()).code, 0);
    expectComplete(2 * kRows);
}

TEST_F(MidairTune, says_that_the_array_is_gone)
{
    const Outcome gone = tune("run --array board --settle 0 --integrate 5ms --quiet "
                              "--device 'sim:?unplug_at=50ms'" +
                              instrument());
    EXPECT_EQ(gone.code, 3) << gone.output;
    EXPECT_TRUE(says(gone, "unplugged")) << gone.output;
    EXPECT_EQ(tune(run() + instrument()).code, 0) << "it goes on";
    expectComplete(kRows);
}

TEST_F(MidairTune, does_not_mix_what_does_not_belong_together)
{
    // An instrument that ends after sixty rows.
    const std::string sixty = " --readings 'exec:sed -u 60q | " + kTune +
                              " rehearse --plan plan.csv --array board --serve'";
    const Outcome ended = tune(run() + sixty);
    EXPECT_EQ(ended.code, 2);
    EXPECT_EQ(ended.output, "midair-tune: the readings ended at row 60\n");
    const std::size_t before = rows().size();
    EXPECT_EQ(before, 60u);
    // Its amplifier was turned up meanwhile.
    const Outcome louder = tune(run() + instrument("--sensitivity 2"));
    EXPECT_EQ(louder.code, 2);
    EXPECT_TRUE(says(louder, "place 0 was begun earlier, and 8 of its rows")) << louder.output;
    EXPECT_TRUE(says(louder, "100 %")) << louder.output;
    EXPECT_EQ(rows().size(), before);
    EXPECT_EQ(tune(run() + instrument("--sensitivity 2") + " --anew").code, 0);
    expectComplete(kRows);
    EXPECT_TRUE(fs::exists(folder + "/readings.csv.old"));

    plan("--mic 0.004 0.003 0.15");
    const Outcome other = tune(run() + instrument());
    EXPECT_EQ(other.code, 2);
    EXPECT_TRUE(says(other, "readings \"readings.csv\" belong to plan ")) << other.output;
    const Outcome fit = tune("fit --array board");
    EXPECT_EQ(fit.code, 2);
    EXPECT_TRUE(says(fit, "readings \"readings.csv\" are of plan ")) << fit.output;
    EXPECT_TRUE(says(tune("fit --array octagon"), "readings \"readings.csv\" are of plan "));
}

TEST_F(MidairTune, plays_within_the_limits_or_not_at_all)
{
    const Outcome capped = tune(run("sim:?max-amplitude=0.2") + instrument());
    EXPECT_EQ(capped.code, 3);
    EXPECT_TRUE(says(capped, "row 16 has transducer 0 at 1.00 of full drive and phase level 0;"))
        << capped.output;
    EXPECT_TRUE(says(capped, " 0.2")) << capped.output;
    EXPECT_TRUE(says(capped, "with a lower --duty")) << capped.output;
    const Outcome pressure = tune(run("sim:?max-pressure=800") + instrument());
    EXPECT_EQ(pressure.code, 3);
    EXPECT_TRUE(says(pressure, "max-pressure can't be")) << pressure.output;
    // One transducer of 249 at full drive is 0.004 of the mean drive.
    const Outcome heat = tune(run("sim:?mean-drive=0.0001&mean-drive-time=100ms") + instrument() +
                              " --patience 0.3");
    EXPECT_EQ(heat.code, 3);
    EXPECT_TRUE(says(heat, "as planned within 0.3 s")) << heat.output;
    fs::remove(folder + "/readings.csv");
    plan("--mic 0.004 0.002 0.15 --duty 30");
    const Outcome ramped = tune(run("sim:?max-amplitude=0.2&ramp=1ms") + instrument());
    EXPECT_EQ(ramped.code, 0) << ramped.output;
    // A row that takes longer than the array holds a field is still wanted. In the foreground, as
    // timeout otherwise sends the signal twice.
    fs::remove(folder + "/readings.csv");
    const Outcome held = shell("cd " + folder + " && timeout --foreground -s INT 2 " + kTune +
                               " run --array board --settle 0 --integrate 0.7s --quiet --device "
                               "'sim:?hold=500ms'" +
                               instrument());
    EXPECT_NE(held.output.find("stopped, the array is silent"), std::string::npos) << held.output;
    EXPECT_GE(rows().size(), 1u);
}

// As scenes have it, in tests/plugin/engine/EarsTest.cpp, and with the same texts.
TEST_F(MidairTune, understands_the_users_caps_or_plays_nothing)
{
    plan("--mic 0.004 0.002 0.15 --duty 30");
    for (const UserCapText& one : userCapTexts())
    {
        const SetVariable variable(one.variable, one.text);
        fs::remove(folder + "/readings.csv");
        const bool plays = one.isUnderstood && !one.needsPoints;
        const Outcome made = tune(run() + instrument());
        EXPECT_EQ(made.code, plays ? 0 : 3) << one.variable << "=" << one.text << made.output;
        if (!one.isUnderstood)
        {
            EXPECT_TRUE(says(made, std::string(one.variable) + " is \"")) << made.output;
        }
    }
    // A row that the limit lowers is none of the plan.
    const SetVariable limit("OSG_MIDAIR_EAR_LIMIT", "60");
    fs::remove(folder + "/readings.csv");
    const Outcome held = tune(run() + instrument());
    EXPECT_EQ(held.code, 3);
    EXPECT_TRUE(says(held, "with a lower --duty")) << held.output;
}

TEST_F(MidairTune, is_silent_at_the_end_and_on_any_error)
{
    const auto lastDuty = [&](const std::string& readings)
    {
        fs::remove(folder + "/readings.csv");
        fs::remove(folder + "/played");
        tune(run("record:" + folder + "/played") + readings + " --patience 0.2");
        const std::string bytes = text("played");
        midair::device::recording::Reader reader(bytes, "played");
        midair::device::recording::Entry entry;
        int fields = 0, last = -1;
        while (reader.next(entry) == midair::device::recording::Stop::MORE)
        {
            const bool isSilence = entry.kind == midair::device::recording::Kind::SILENCE;
            last = 0;
            for (const std::uint8_t duty : entry.signal.duty)
                last += isSilence ? 0 : duty;
            fields += last > 0 ? 1 : 0;
        }
        EXPECT_GT(fields, 0) << readings;
        return last;
    };
    EXPECT_EQ(lastDuty(instrument()), 0);
    const std::string twenty =
        "for i in 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20; do echo 1,0; "
        "done; ";
    EXPECT_EQ(lastDuty(" --readings 'exec:" + twenty + "'"), 0);          // ends
    EXPECT_EQ(lastDuty(" --readings 'exec:" + twenty + "sleep 9'"), 0);   // says nothing more
    EXPECT_EQ(lastDuty(" --readings 'exec:" + twenty + "echo volt'"), 0); // says what is no number
    EXPECT_EQ(lastDuty(" --clip 0.5 --readings 'exec:sed -u \"s/.*/1,0/;1,20s/.*/0,0/\"'"), 0);
}

TEST_F(MidairTune, says_what_an_instrument_did_wrong)
{
    const auto outcomeOf = [&](const std::string& readings)
    {
        const Outcome outcome = tune(run() + readings + " --patience 0.2");
        EXPECT_EQ(outcome.code, 2) << outcome.output;
        return outcome.output;
    };
    EXPECT_EQ(outcomeOf(" --readings 'exec:true'"), "midair-tune: the readings ended at row 0\n");
    EXPECT_EQ(outcomeOf(" --readings 'exec:sleep 9'"),
              "midair-tune: no reading of row 0 within 0.2 s\n");
    EXPECT_NE(outcomeOf(" --readings 'exec:echo 5'").find("the method single needs re,im"),
              std::string::npos);
    EXPECT_EQ(outcomeOf(" --readings 'exec:echo 5 V'"),
              "midair-tune: the reading of row 0 is \"5 V\"; it should be re,im or a level\n");
    EXPECT_NE(outcomeOf(" --readings 'exec:echo 3,4' --clip 5")
                  .find("the microphone clips: row 0 reads 5, its limit is 5;"),
              std::string::npos);
    EXPECT_NE(outcomeOf(" --readings nowhere").find("readings \"nowhere\" can't be read"),
              std::string::npos);
}

TEST_F(MidairTune, reads_stdin_and_instruments_with_a_clock_of_their_own)
{
    array = "ultraino64";
    plan("--mic 0 0 0.1");
    const Outcome piped = shell("cd " + folder + " && " + kTune +
                                " rehearse --array ultraino64 | sed '5s/.*/nan,nan/' | " + kTune +
                                " " + run() + " --readings -");
    EXPECT_EQ(piped.code, 0) << piped.output;
    EXPECT_TRUE(says(piped, "17,0,0,0.1,0\n")) << "requests: " << piped.output;
    EXPECT_NE(text("readings.csv").find("\n4,nan,nan\n"), std::string::npos);
    const Outcome fit = tune("fit --array ultraino64");
    EXPECT_TRUE(says(fit, "left out: 4\n")) << fit.output;

    // It counts without being asked; rows take the newest.
    fs::remove(folder + "/readings.csv");
    write("count.sh", "i=0; while :; do echo $i,1; i=$((i+1)); done");
    const Outcome own =
        tune("run --array ultraino64 --settle 0 --integrate 3ms --free-running --quiet "
             "--device sim: --readings 'exec:sh count.sh'");
    EXPECT_EQ(own.code, 0) << own.output;
    std::istringstream lines(text("readings.csv"));
    double last = -1.0;
    int count = 0;
    for (std::string line; std::getline(lines, line);)
    {
        if (line[0] == '#') continue;
        const double value = std::stod(line.substr(line.find(',') + 1));
        EXPECT_GT(value, last) << line;
        last = value;
        ++count;
    }
    EXPECT_EQ(count, 16 + 64);
    EXPECT_GT(last, 3 * count) << "lines from before the rows sounded count";
}

TEST_F(MidairTune, refuses_what_it_cannot_fit)
{
    ASSERT_EQ(tune(run() + instrument("--place-error 0.05")).code, 0);
    const Outcome lost = tune("fit --array board --out tuned.json");
    EXPECT_EQ(lost.code, 1) << lost.output;
    EXPECT_TRUE(says(lost, "refused     the phases at place 0 ")) << lost.output;
    EXPECT_FALSE(fs::exists(folder + "/tuned.json"));
    EXPECT_EQ(tune("plan --array board --method singel --mic 0 0 0.1").code, 2);
    EXPECT_TRUE(says(tune("plan --array board"), "--mic X Y Z"));
    EXPECT_EQ(tune("plan --array board --mic 0 0").code, 2);
}

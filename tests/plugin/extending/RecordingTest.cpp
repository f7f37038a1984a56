#include "haptics/base/threads/SteadyClock.h"
#include "tests/Eventually.h"
#include "tests/device/limits/UserCapTexts.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/ArrayDescription>
#include <osgMidair/HapticField>
#include <osgMidair/Recording>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>

using namespace osgMidair;

namespace
{

/// The name of a recording, gone at the end.
struct RecordingFile
{
    const std::string path =
        testing::TempDir() + "midair-recording-" + std::to_string(::getpid()) + ".rec";
    RecordingFile() { std::filesystem::remove(path); }
    ~RecordingFile() { std::filesystem::remove(path); }
};

std::vector<std::complex<float>> drive(unsigned int m, float phase)
{
    std::vector<std::complex<float>> q(m);
    for (unsigned int i = 0; i < m; ++i)
        q[i] = std::polar(1.0F, phase * static_cast<float>(i));
    return q;
}

/// Records one field of nine transducers at full drive.
void recordAField(const std::string& path)
{
    std::string error;
    const osg::ref_ptr<Recorder> recorder = Recorder::open(path, 9, error);
    ASSERT_TRUE(recorder) << error;
    recorder->record(drive(9, 0.5F));
    letPass(0.05); // in which it is played
}

} // namespace

TEST(Recording, KeepsWhatWasRecorded)
{
    const RecordingFile file;
    std::string error;
    osg::ref_ptr<Recorder> recorder = Recorder::open(file.path, 9, error);
    ASSERT_TRUE(recorder) << error;
    EXPECT_TRUE(recorder->record(drive(9, 0.5F)));
    EXPECT_FALSE(recorder->record(drive(8, 0.5F))) << "another number of transducers";
    EXPECT_FALSE(recorder->record(std::vector<std::complex<float>>(9, std::nanf(""))));
    recorder->silence();
    EXPECT_FALSE(Recorder::open(file.path, 9, error)) << "it is being recorded";
    recorder = nullptr;

    const osg::ref_ptr<RecordingReader> reader = RecordingReader::open(file.path, error);
    ASSERT_TRUE(reader) << error;
    EXPECT_EQ(reader->getNumTransducers(), 9u);
    RecordedField field;
    ASSERT_TRUE(reader->next(field));
    const auto expected = drive(9, 0.5F);
    for (std::size_t i = 0; i < 9; ++i)
        EXPECT_NEAR(std::abs(field.activations[i] - expected[i]), 0.0, M_PI / 256 + 1e-5);
    const double begun_s = field.time_s;
    ASSERT_TRUE(reader->next(field));
    EXPECT_GE(field.time_s, begun_s);
    EXPECT_EQ(field.activations, std::vector<std::complex<float>>(9));
    while (reader->next(field))
        EXPECT_EQ(field.activations, std::vector<std::complex<float>>(9));
    EXPECT_EQ(reader->getError(), "");
}

TEST(Recording, AFieldOfASceneIsRecordedAndPlayed)
{
    const RecordingFile file;
    std::vector<std::complex<float>> played;
    std::string error;
    {
        BoxScene box;
        HeadlessViewer viewer(box.scene);
        ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
        const osg::ref_ptr<Recorder> recorder = Recorder::open(file.path, 249, error);
        ASSERT_TRUE(recorder) << error;
        const auto field = box.scene->getField();
        ASSERT_TRUE(recorder->record(*field));
        played = field->getActivations();
    }
    PlayerOptions options;
    options.maxAmplitude = 0.5;
    options.loop = true;
    const osg::ref_ptr<Player> player = Player::open(file.path, "null:", error, options);
    ASSERT_TRUE(player) << error;
    const auto loudest = [&]
    {
        float most = 0.0F;
        for (const std::complex<float>& q : player->getActivations())
            most = std::max(most, std::abs(q));
        return most;
    };
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (loudest() == 0.0F && std::chrono::steady_clock::now() < end)
        std::this_thread::yield();
    EXPECT_LE(loudest(), 0.5F + 1e-5F) << player->getStatus();
    player->stop();
    EXPECT_EQ(loudest(), 0.0F);
}

TEST(Recording, IsPlayedWithinTheUsersCaps)
{
    const RecordingFile file;
    std::string error;
    recordAField(file.path);
    PlayerOptions options;
    options.loop = true;
    ::setenv("OSG_MIDAIR_MAX_AMPLITUDE", "0.05", 1);
    osg::ref_ptr<Player> player = Player::open(file.path, "null:", error, options);
    ASSERT_TRUE(player) << error;
    float most = 0.0F;
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (most == 0.0F && std::chrono::steady_clock::now() < end)
        for (const std::complex<float>& q : player->getActivations())
            most = std::max(most, std::abs(q));
    EXPECT_GT(most, 0.01F);
    EXPECT_LE(most, 0.05F + 1e-5F) << player->getStatus();
    player = nullptr;
    ::setenv("OSG_MIDAIR_MAX_AMPLITUDE", "much", 1);
    EXPECT_FALSE(Player::open(file.path, "null:", error, options));
    EXPECT_NE(error.find("OSG_MIDAIR_MAX_AMPLITUDE is \"much\""), std::string::npos) << error;
    ::unsetenv("OSG_MIDAIR_MAX_AMPLITUDE");
    ::setenv("OSG_MIDAIR_MAX_PRESSURE", "2000", 1); // without control points it can't be held
    EXPECT_FALSE(Player::open(file.path, "null:", error, options));
    ::unsetenv("OSG_MIDAIR_MAX_PRESSURE");
}

// As scenes have it, in EarsTest.cpp, and with the same texts.
TEST(Recording, EachTextOfTheUsersCapsIsUnderstoodOrRefused)
{
    const RecordingFile file;
    std::string error;
    recordAField(file.path);
    const osg::ref_ptr<RecordingReader> reader = RecordingReader::open(file.path, error);
    ASSERT_TRUE(reader) << error;
    const unsigned int count = reader->getNumTransducers();
    ArrayDescription array;
    array.addGrid({}, {0, 0, 1}, {1, 0, 0}, count, 1, 0.0105);
    PlayerOptions known;
    known.useArray(array);
    for (const UserCapText& one : userCapTexts())
    {
        const SetVariable variable(one.variable, one.text);
        const bool plays = one.isUnderstood && !one.needsPoints;
        EXPECT_EQ(Player::open(file.path, "null:", error, known).valid(), plays)
            << one.variable << "=" << one.text << ": " << error;
        if (!one.isUnderstood)
        {
            EXPECT_EQ(error.rfind(std::string(one.variable) + " is \"", 0), 0U) << error;
        }
    }
    const SetVariable limit("OSG_MIDAIR_EAR_LIMIT", "110");
    EXPECT_FALSE(Player::open(file.path, "null:", error, {})) << "nobody says where they are";
    EXPECT_NE(error.find("ear limit of 110 dB can't be held"), std::string::npos) << error;
}

TEST(Recording, IsHeldToTheUsersEarLimit)
{
    const RecordingFile file;
    std::string error;
    recordAField(file.path);
    const osg::ref_ptr<RecordingReader> reader = RecordingReader::open(file.path, error);
    ASSERT_TRUE(reader) << error;
    ArrayDescription array;
    array.addGrid({}, {0, 0, 1}, {1, 0, 0}, reader->getNumTransducers(), 1, 0.0105);
    PlayerOptions options;
    options.loop = true;
    options.useArray(array);
    const auto loudest = [&]
    {
        const osg::ref_ptr<Player> player = Player::open(file.path, "null:", error, options);
        EXPECT_TRUE(player) << error;
        float most = 0.0F;
        const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
        while (player && most == 0.0F && std::chrono::steady_clock::now() < end)
            for (const std::complex<float>& q : player->getActivations())
                most = std::max(most, std::abs(q));
        return most;
    };
    const float free = loudest();
    const SetVariable limit("OSG_MIDAIR_EAR_LIMIT", "110");
    const float held = loudest();
    EXPECT_GT(held, 0.0F);
    EXPECT_LT(held, 0.5F * free);
}

TEST(Recording, IsSilentUnderAHoldUnlessTheProgramLeads)
{
    const RecordingFile file;
    std::string error;
    recordAField(file.path);
    PlayerOptions options;
    options.loop = true;
    const osg::ref_ptr<Player> player = Player::open(file.path, "null:?hold=300ms", error, options);
    ASSERT_TRUE(player) << error;
    const auto sounds = [&]
    {
        const auto q = player->getActivations();
        return std::any_of(q.begin(), q.end(), [](auto one) { return std::abs(one) > 0.0F; });
    };
    const auto heardIn = [&](double seconds)
    {
        bool any = false;
        const double end_s = midair::base::steadySeconds() + seconds;
        eventually(
            [&]
            {
                any = sounds() || any;
                return midair::base::steadySeconds() >= end_s;
            });
        return any;
    };
    const auto soundsLed = [&]
    {
        player->keepAlive();
        return sounds();
    };
    const double led_s = midair::base::steadySeconds() + 0.5; // longer than the hold
    EXPECT_TRUE(eventually([&] { return soundsLed() && midair::base::steadySeconds() >= led_s; }));
    heardIn(0.6); // hangs
    EXPECT_FALSE(heardIn(0.3));
    EXPECT_NE(player->getStatus().find("no sign of life"), std::string::npos)
        << player->getStatus();
    EXPECT_FALSE(player->isFinished());
    EXPECT_TRUE(eventually(soundsLed)) << "it goes on";
}

TEST(Recording, DeadTransducersAreNeverDriven)
{
    const RecordingFile file;
    std::string error;
    recordAField(file.path);
    ArrayDescription array;
    array.transducers.resize(9);
    array.transducers[8].board = 1;
    array.dead = {7, 2, 7};
    PlayerOptions options;
    options.useArray(array);
    EXPECT_EQ(options.board, (std::vector<int>{0, 0, 0, 0, 0, 0, 0, 0, 1}));
    options.loop = true;
    const osg::ref_ptr<Player> player = Player::open(file.path, "null:", error, options);
    ASSERT_TRUE(player) << error;
    EXPECT_NE(player->getStatus().find("; 2 dead transducers left out"), std::string::npos)
        << player->getStatus();
    std::vector<std::complex<float>> played(9);
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while (std::abs(played[0]) == 0.0F && std::chrono::steady_clock::now() < end)
    {
        std::this_thread::yield();
        played = player->getActivations();
    }
    for (const std::size_t i : {0, 1, 3, 4, 5, 6, 8})
        EXPECT_GT(std::abs(played[i]), 0.9F) << i;
    EXPECT_EQ(std::abs(played[2]), 0.0F);
    EXPECT_EQ(std::abs(played[7]), 0.0F);
    options.dead = {9};
    EXPECT_FALSE(Player::open(file.path, "null:", error, options));
    EXPECT_EQ(error, "transducer 9 is dead, but the recording is for 9, from 0");
}

TEST(Recording, SaysWhyItDoesNotPlay)
{
    const RecordingFile file;
    std::string error;
    EXPECT_FALSE(Player::open(file.path, "null:", error));
    EXPECT_NE(error.find(file.path), std::string::npos) << error;
    std::ofstream(file.path) << "no recording";
    EXPECT_FALSE(RecordingReader::open(file.path, error));
    EXPECT_FALSE(Recorder::open(file.path, 9, error)) << "a file of another kind";
    EXPECT_EQ(Recorder::open(file.path, 0, error), nullptr);
    EXPECT_EQ(error.find("transducers is 0; it must be within 1 .. "), 0u) << error;
    std::filesystem::remove(file.path);
    {
        const osg::ref_ptr<Recorder> recorder = Recorder::open(file.path, 9, error);
        ASSERT_TRUE(recorder);
        recorder->record(drive(9, 1.0F));
    }
    EXPECT_FALSE(Player::open(file.path, "nosuch:", error));
    EXPECT_EQ(error.find("device \"nosuch:\": unknown kind"), 0u) << error;
    EXPECT_FALSE(Player::open(file.path, "play:x", error));
    EXPECT_FALSE(Player::open(file.path, "null:?max-pressure=500", error));
    EXPECT_NE(error.find("max-pressure can't be held"), std::string::npos) << error;
    PlayerOptions options;
    options.speed = 0.0;
    EXPECT_FALSE(Player::open(file.path, "null:", error, options));
    EXPECT_EQ(error, "speed is 0; it must be within 0.001 .. 1000");
}

TEST(RecordingWriter, WritesBakedFieldsThatAreReadAsTheyWere)
{
    const RecordingFile file;
    const BakedField first{0, {0, 64}, {255, 128}};
    const BakedField silence{20000000, {}, {}};
    const BakedField last{30000000, {1, 2}, {3, 4}};
    const auto write = [&]
    {
        osg::ref_ptr<RecordingWriter> writer = new RecordingWriter(2);
        for (const BakedField& field : {first, silence, last})
            EXPECT_TRUE(writer->record(field));
        EXPECT_FALSE(writer->record({29999999, {}, {}})) << "before the last one";
        EXPECT_FALSE(writer->record({40000000, {1}, {1}})) << "another number of transducers";
        EXPECT_FALSE(writer->record({40000000, {1, 2}, {1}}));
        writer->end(40000000);
        EXPECT_FALSE(writer->record({50000000, {}, {}})) << "after the end";
        return writer;
    };
    const std::string bytes = write()->take();
    EXPECT_EQ(bytes, write()->take()) << "the same fields give the same bytes";
    EXPECT_EQ(bytes.rfind(RecordingWriter::kBeginning, 0), 0u);
    std::string error;
    const osg::ref_ptr<RecordingWriter> writer = write();
    ASSERT_TRUE(writer->save(file.path, error)) << error;
    EXPECT_EQ(writer->take(), "");
    EXPECT_EQ(std::filesystem::file_size(file.path), bytes.size());
    for (const osg::ref_ptr<RecordingReader>& reader :
         {RecordingReader::open(file.path, error), RecordingReader::read(bytes, "it", error)})
    {
        ASSERT_TRUE(reader) << error;
        EXPECT_EQ(reader->getNumTransducers(), 2u);
        BakedField field;
        for (const BakedField& wanted : {first, silence, last})
        {
            ASSERT_TRUE(reader->next(field));
            EXPECT_EQ(field.time_ns, wanted.time_ns);
            EXPECT_EQ(field.phase, wanted.phase);
            EXPECT_EQ(field.duty, wanted.duty);
        }
        EXPECT_FALSE(reader->next(field));
        EXPECT_EQ(reader->getError(), "");
    }
    EXPECT_FALSE(RecordingReader::read("MIDAIR", "it", error));
    // No other file is replaced unless it is asked for.
    std::ofstream(file.path, std::ios::trunc) << "a letter";
    EXPECT_FALSE(write()->save(file.path, error));
    EXPECT_TRUE(write()->save(file.path, error, true)) << error;
}

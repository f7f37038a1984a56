#include "tests/plugin/KitTest.h"

#include <osgMidair/ArrayDescription>
#include <osgMidair/HapticField>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>

using namespace osgMidair;

namespace
{

ArrayDescription ownArray()
{
    ArrayDescription array;
    array.name = "two boards";
    array.addGrid({0, 0, 0}, {0, 0, 2}, {1, 0, 0}, 8, 10, 0.0105);
    array.addGrid({0, 0, 0.3}, {0, 0, -1}, {1, 0, 0}, 8, 10, 0.0105);
    return array;
}

/// The file of an array, gone at the end.
class ArrayFile
{
public:
    ArrayFile() : path(testing::TempDir() + "midair-array-" + std::to_string(::getpid()) + ".json")
    {
    }
    ~ArrayFile() { std::filesystem::remove(path); }

    void save(const ArrayDescription& array) const
    {
        std::string error;
        ASSERT_TRUE(array.save(path, error)) << error;
    }
    void write(const std::string& text) const { std::ofstream(path) << text; }

    const std::string path;
};

} // namespace

TEST(ArrayDescription, AGridStandsWhereItIsAskedFor)
{
    const ArrayDescription array = ownArray();
    ASSERT_EQ(array.transducers.size(), 160u);
    std::string error;
    EXPECT_TRUE(array.isValid(error)) << error;
    EXPECT_EQ(array.transducers[0].position, osg::Vec3d(-3.5 * 0.0105, -4.5 * 0.0105, 0.0));
    EXPECT_NEAR(
        array.transducers[1].position.x() - array.transducers[0].position.x(), 0.0105, 1e-12);
    EXPECT_NEAR(
        array.transducers[8].position.y() - array.transducers[0].position.y(), 0.0105, 1e-12);
    EXPECT_EQ(array.transducers[159].normal, osg::Vec3d(0, 0, -1));
    EXPECT_EQ(array.transducers[79].board, 0);
    EXPECT_EQ(array.transducers[80].board, 1);
    // Seen along its normal, the other board's rows run the other way.
    EXPECT_GT(array.transducers[80].position.y(), 0.0);
}

TEST(ArrayDescription, FilesKeepIt)
{
    const ArrayFile file;
    ArrayDescription array = ownArray();
    array.dead = {7, 3};
    array.transducers[5].gain = 0.5;
    array.transducers[6].phaseOffset_rad = -1.25;
    array.directivity = ArrayDescription::POINT;
    array.phaseLevels = 32;
    array.ringing_s = 2.76e-4;
    array.amplitudeLevels = {0.0F, 1.0F};
    file.save(array);
    ArrayDescription again;
    std::string error;
    ASSERT_TRUE(ArrayDescription::load(file.path, again, error)) << error;
    EXPECT_EQ(again.name, "two boards");
    EXPECT_EQ(again.dead, (std::vector<unsigned int>{3, 7}));
    EXPECT_EQ(again.transducers[5].gain, 0.5);
    EXPECT_EQ(again.transducers[3].gain, 1.0) << "of a dead one, for when it is mended";
    EXPECT_EQ(again.transducers[6].phaseOffset_rad, -1.25);
    EXPECT_EQ(again.directivity, ArrayDescription::POINT);
    EXPECT_EQ(again.phaseLevels, 32);
    EXPECT_EQ(again.ringing_s, 2.76e-4);
    EXPECT_EQ(again.amplitudeLevels, array.amplitudeLevels);
    EXPECT_EQ(again.transducers[159].board, 1);

    EXPECT_TRUE(ArrayDescription::load("sonicsurface", again, error));
    EXPECT_EQ(again.transducers.size(), 256u);
    EXPECT_FALSE(ArrayDescription::load("nosuch", again, error));
    EXPECT_EQ(error.find("array 'nosuch': there is no such file"), 0u) << error;
    EXPECT_EQ(again.transducers.size(), 256u) << "left as it was";
}

TEST(ArrayDescription, WhatIsOutOfRangeIsNamed)
{
    struct Mistake
    {
        void (*make)(ArrayDescription&);
        std::string message;
    };
    const Mistake mistakes[] = {
        {[](ArrayDescription& a) { a.transducers.clear(); },
         "there are 0 transducers; there must be 1 .. 65536"},
        {[](ArrayDescription& a) { a.transducers[3].position.x() = std::nan(""); },
         "transducer 3 is at (nan, -0.04725, 0) m; coordinates must be within -10 .. 10"},
        {[](ArrayDescription& a) { a.transducers[3].normal.set(0, 0, 0); },
         "transducer 3 has the normal (0, 0, 0); it must have a direction"},
        {[](ArrayDescription& a) { a.transducers[3].gain = -1.0; },
         "transducer 3 has the gain -1; it must be within 0 .. 1000"},
        {[](ArrayDescription& a) { a.transducers[3].phaseOffset_rad = 1e4; },
         "transducer 3 has the phase offset 10000; it must be within -1000 .. 1000 rad"},
        {[](ArrayDescription& a) { a.transducers[3].board = 2; },
         "transducer 3 is on board 2; boards count up from 0 without a gap"},
        {[](ArrayDescription& a) { a.transducers[0].board = 1; },
         "transducer 0 is on a board other than 0, being the first"},
        {[](ArrayDescription& a) { a.dead = {160}; },
         "transducer 160 is dead, but there are 160, from 0"},
        {[](ArrayDescription& a) { a.ringing_s = std::nan(""); },
         "ringing_s is nan; it must be within 0 .. 0.01"},
        {[](ArrayDescription& a) { a.phaseLevels = 1; },
         "phaseLevels is 1; it must be 0 or 2 .. 65536"},
        {[](ArrayDescription& a) {
             a.amplitudeLevels = {0.0F, 0.5F};
         },
         "the last amplitude level is 0.5; it must be 1"}};
    for (const Mistake& mistake : mistakes)
    {
        ArrayDescription array = ownArray();
        mistake.make(array);
        std::string error;
        EXPECT_FALSE(array.isValid(error));
        EXPECT_EQ(error, mistake.message);
        EXPECT_FALSE(array.save("/nowhere/x.json", error));
        EXPECT_EQ(error, "array \"two boards\": " + mistake.message);
    }
}

TEST(ArrayDescription, ASceneIsPlayedOnIt)
{
    BoxScene box;
    ArrayDescription array = ownArray();
    for (unsigned int i = 0; i < 160; i += 5)
        array.dead.push_back(i);
    box.scene->setArrayDescription(array);
    EXPECT_EQ(box.scene->getArray(), "");
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    const auto field = box.scene->getField();
    ASSERT_TRUE(field);
    EXPECT_EQ(field->getArray()->name, "two boards");
    EXPECT_EQ(field->getArray()->dead, array.dead);
    const auto q = field->getActivations();
    ASSERT_EQ(q.size(), 160u);
    for (std::size_t i = 0; i < q.size(); ++i)
        EXPECT_EQ(std::abs(q[i]) > 0.0F, i % 5 != 0) << i;

    box.scene->setArray("board"); // takes its place
    ASSERT_TRUE(viewer.framesUntil(
        [&] { return box.points() > 0 && box.scene->getField()->getActivations().size() == 249; }));
}

TEST(ArrayDescription, OneThatIsNotValidPlaysNothingAndSaysWhy)
{
    BoxScene box;
    ArrayDescription array = ownArray();
    array.transducers[3].gain = -1.0;
    box.scene->setArrayDescription(array);
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil(
        [&]
        {
            return says(
                *box.scene,
                "array \"two boards\": transducer 3 has the gain -1; it must be within 0 .. "
                "1000; nothing is played");
        }));
    EXPECT_EQ(box.scene->getField(), nullptr);
}

TEST(ArrayDescription, AFileThatChangesIsReadAgainThoughNothingMoves)
{
    const ArrayFile file;
    ArrayDescription array = ownArray();
    file.save(array);
    BoxScene box;
    box.scene->setArray(file.path);
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    const auto isPlayed = [&](std::size_t transducer, bool wanted)
    {
        const auto field = box.scene->getField();
        if (!field || field->getPoints().empty()) return false;
        return (std::abs(field->getActivations()[transducer]) > 0.0F) == wanted;
    };
    const auto saysSoon = [&](const std::string& part) // a scene at rest is looked at now and then
    { return viewer.framesUntil([&] { return says(*box.scene, part); }); };
    ASSERT_TRUE(isPlayed(17, true));
    array.dead = {17};
    file.save(array);
    ASSERT_TRUE(viewer.framesUntil([&] { return isPlayed(17, false); }));
    EXPECT_TRUE(
        saysSoon("array \"two boards\" has changed and was read again: 159 of 160 transducers "
                 "are driven"));

    // A file that is wrong silences the array and says why, until it is right again.
    file.write("{ \"half\": ");
    ASSERT_TRUE(viewer.framesUntil([&] { return box.scene->getField() == nullptr; }));
    EXPECT_TRUE(saysSoon("; nothing is played"));
    EXPECT_EQ(box.scene->getStatistics().device, "not open");
    array.dead = {};
    file.save(array);
    ASSERT_TRUE(viewer.framesUntil([&] { return isPlayed(17, true); }));
}

TEST(ArrayDescription, AFileThatIsRightAgainIsToldEachTime)
{
    const ArrayFile file;
    file.write("{ \"half\": ");
    BoxScene box;
    box.scene->setArray(file.path);
    HeadlessViewer viewer(box.scene);
    const auto count = [&](const std::string& code)
    {
        for (const HapticMessage& message : box.scene->getStatistics().told)
            if (message.code == code) return message.count;
        return std::uint64_t(0);
    };
    ASSERT_TRUE(viewer.framesUntil([&] { return count("array.invalid") == 1; }));
    file.save(ownArray());
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    ASSERT_TRUE(viewer.framesUntil([&] { return count("array.reread") == 1; }));
    file.write("{ \"half\": ");
    ASSERT_TRUE(viewer.framesUntil([&] { return count("array.invalid") == 2; }));
    file.save(ownArray());
    EXPECT_TRUE(viewer.framesUntil([&] { return count("array.reread") == 2; }));
}

TEST(ArrayDescription, AFileThatIsReadForAnotherSettingHasNotChanged)
{
    const ArrayFile file;
    file.save(ownArray());
    BoxScene box;
    box.scene->setArray(file.path);
    box.scene->setSolver("nonsense");
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return !box.scene->getStatistics().told.empty(); }));
    box.scene->setSolver("");
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    viewer.frames(3);
    for (const HapticMessage& message : box.scene->getStatistics().told)
        EXPECT_EQ(message.code, "solver.unknown") << message.text;
}

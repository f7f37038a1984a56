// Fields that a program waits for, and that it solves at once.
#include "tests/plugin/KitTest.h"

#include <osgMidair/FieldCallback>
#include <osgMidair/HapticField>
#include <osgMidair/HapticPoints>

#include <atomic>
#include <cmath>
#include <fstream>
#include <stdexcept>
#include <thread>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

osg::ref_ptr<osg::FrameStamp> stampOf(unsigned int frame)
{
    osg::ref_ptr<osg::FrameStamp> stamp = new osg::FrameStamp;
    stamp->setFrameNumber(frame);
    stamp->setSimulationTime(0.01 * frame);
    return stamp;
}

struct Told : FieldCallback
{
    void solved(const HapticField& field) override
    {
        frames.push_back(field.getFrameNumber());
        thread = std::this_thread::get_id();
        if (throws) throw std::runtime_error("no more");
    }
    std::vector<std::uint64_t> frames;
    std::thread::id thread;
    bool throws = false;
};

} // namespace

TEST(HapticScene, AFieldIsWaitedForOnTheUpdateThread)
{
    BoxScene box;
    std::string why;
    EXPECT_FALSE(box.scene->waitForField(1e6, &why));
    EXPECT_NE(why.find("nothing is played: "), std::string::npos) << why;
    for (unsigned int frame = 1; frame <= 5; ++frame)
    {
        box.move(0.01 * frame);
        box.scene->update(stampOf(frame));
        const osg::ref_ptr<const HapticField> field = box.scene->waitForField(60.0, &why);
        ASSERT_TRUE(field) << why;
        EXPECT_EQ(field->getFrameNumber(), frame);
        EXPECT_EQ(why, "");
        EXPECT_EQ(field, box.scene->getField());
    }
    // Not yet is told after no time.
    box.scene->setEnabled(false);
    box.scene->update(stampOf(6));
    EXPECT_FALSE(box.scene->waitForField(1e6, &why));
    EXPECT_NE(why.find("the scene is disabled"), std::string::npos) << why;
    box.scene->setEnabled(true);
    box.scene->setMaxPressure(-1.0);
    box.scene->update(stampOf(7));
    EXPECT_FALSE(box.scene->waitForField(1e6, &why));
    EXPECT_NE(why.find("maxPressure"), std::string::npos) << why;
}

TEST(HapticScene, WhoWaitsElsewhereKeepsNoFrameWaiting)
{
    BoxScene box;
    box.scene->update(stampOf(1));
    std::atomic<bool> ends{false};
    std::atomic<int> fields{0};
    std::thread waits(
        [&]
        {
            while (!ends)
                if (box.scene->waitForField(60.0)) ++fields;
        });
    unsigned int frame = 1;
    EXPECT_TRUE(eventually(
        [&]
        {
            box.move(0.001 * (frame % 40));
            box.scene->update(stampOf(++frame));
            return fields > 3;
        }));
    ends = true;
    waits.join();
}

TEST(HapticScene, NewFieldsAreToldOnTheUpdateThread)
{
    BoxScene box;
    const osg::ref_ptr<Told> told = new Told;
    box.scene->setFieldCallback(told);
    EXPECT_EQ(box.scene->getFieldCallback(), told);
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return !told->frames.empty(); }));
    EXPECT_EQ(told->thread, std::this_thread::get_id());
    const std::uint64_t first = told->frames.back();
    told->throws = true;
    box.move(0.02);
    ASSERT_TRUE(viewer.framesUntil([&] { return told->frames.back() > first; }));
    EXPECT_TRUE(says(*box.scene, "the field callback has thrown \"no more\""));
    box.scene->setFieldCallback(nullptr);
    const std::size_t count = told->frames.size();
    viewer.frames(10);
    EXPECT_EQ(told->frames.size(), count);
}

TEST(HapticScene, IsSolvedAtOnceAndOpensNothing)
{
    BoxScene box;
    box.scene->setDevice("record:" + testing::TempDir() + "none.midair");
    std::string why;
    const osg::ref_ptr<const HapticField> field = box.scene->solve(&why);
    ASSERT_TRUE(field) << why;
    EXPECT_EQ(why, "");
    EXPECT_GT(field->getPoints().size(), 10u);
    EXPECT_FALSE(field->isPlaying());
    EXPECT_EQ(field->getObjects().at(0).node, box.surface.get());
    const HapticField::ControlPoint& point = field->getPoints().at(0);
    EXPECT_NEAR(static_cast<double>(std::abs(field->getPressure(point.position))),
                point.achieved_Pa,
                0.01 * point.achieved_Pa);
    EXPECT_EQ(box.scene->getStatistics().state, ArrayState::CLOSED);
    EXPECT_FALSE(std::ifstream(testing::TempDir() + "none.midair"));
    // Its caps hold.
    box.scene->setMaxPressure(200.0);
    const osg::ref_ptr<const HapticField> capped = box.scene->solve();
    ASSERT_TRUE(capped);
    for (const HapticField::ControlPoint& one : capped->getPoints())
        EXPECT_LE(one.achieved_Pa, 200.0);
    box.scene->setMaxPressure(-1.0);
    EXPECT_FALSE(box.scene->solve(&why));
    EXPECT_NE(why.find("maxPressure"), std::string::npos) << why;
}

TEST(HapticScene, IsSolvedWhileItIsPlayedAndPlaysOn)
{
    BoxScene box;
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() > 0; }));
    std::string why;
    const osg::ref_ptr<const HapticField> solved = box.scene->solve(&why);
    ASSERT_TRUE(solved) << why;
    EXPECT_EQ(box.scene->getStatistics().state, ArrayState::PLAYING);
    box.move(0.03);
    const osg::ref_ptr<const HapticField> moved = box.scene->solve();
    ASSERT_TRUE(moved);
    viewer.frame();
    const osg::ref_ptr<const HapticField> played = box.scene->waitForField(60.0, &why);
    ASSERT_TRUE(played) << why;
    ASSERT_EQ(played->getPoints().size(), moved->getPoints().size());
    EXPECT_LT((played->getPoints()[0].position - moved->getPoints()[0].position).length(), 1e-6);
    // What is nowhere in reach is a field in which nothing sounds.
    box.transform->setMatrix(osg::Matrixd::translate(0.0, 0.0, 50.0));
    const osg::ref_ptr<const HapticField> nothing = box.scene->solve(&why);
    ASSERT_TRUE(nothing);
    EXPECT_TRUE(nothing->getPoints().empty());
    EXPECT_NE(why, "");
}

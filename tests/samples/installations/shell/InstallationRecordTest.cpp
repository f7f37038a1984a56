#include "samples/installations/shell/InstallationRecord.h"

#include <gtest/gtest.h>

using midair::samples::InstallationRecord;

namespace
{

/// The record hears what OSG says; afterwards that goes where it went before.
struct RecordInTest
{
    RecordInTest() = default;
    ~RecordInTest() { osg::setNotifyHandler(before); }
    RecordInTest(const RecordInTest&) = delete;
    RecordInTest& operator=(const RecordInTest&) = delete;

    const osg::ref_ptr<osg::NotifyHandler> before = osg::getNotifyHandler();
    InstallationRecord record;

    /// A frame in which a fingertip gets \a force_N at the strongest place.
    void addFrame(double now_s, double force_N)
    {
        osgMidair::HapticStatistics now;
        now.state = osgMidair::ArrayState::PLAYING;
        now.fingertipForce_N = force_N;
        record.addFrame({now_s, false, false}, now);
    }
    double largest_mN() const { return record.figures({}).at("largestForce_mN"); }
};

} // namespace

TEST(InstallationRecord, TouchesGetNoMoreThanIsPlayed)
{
    RecordInTest test;
    osgMidair::Touch touch;
    touch.force = 49e-3; // the upper estimate for a whole finger
    EXPECT_EQ(test.record.felt(touch).force, 0.0) << "before the first field";
    test.addFrame(0.0, 2.4e-3);
    test.record.addTouch(test.record.felt(touch));
    EXPECT_NEAR(test.largest_mN(), 2.4, 1e-9);
    test.addFrame(0.1, 0.0); // silence
    test.record.addStroke(test.record.felt(touch));
    EXPECT_NEAR(test.largest_mN(), 2.4, 1e-9);
    test.addFrame(0.2, 1.0);
    test.record.addStroke(test.record.felt(touch));
    EXPECT_NEAR(test.largest_mN(), 49.0, 1e-9) << "another place is stronger";
    EXPECT_EQ(test.record.figures({}).at("touches"), 1);
}

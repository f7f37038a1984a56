#include "haptics/propagation/PressureField.h"
#include "tests/Eventually.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/HapticField>
#include <osgMidair/PlayedPressure>

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// A scene that has played for a while, and its field.
struct Played
{
    BoxScene box;
    HeadlessViewer viewer{box.scene};
    osg::ref_ptr<const HapticField> field;

    explicit Played(const std::string& device)
    {
        box.scene->setDevice(device);
        viewer.framesUntil(
            [&]
            {
                field = box.scene->getField();
                return field && field->isPlaying();
            });
        if (device == "null:") return; // it doesn't know what it plays
        // What was switched on has settled.
        const osg::Vec3d place = field->getPoints().front().position;
        const auto isSteady = [&]
        {
            const auto heard_Pa = playedPressure(*box.scene, place, 0.06, 5e3);
            return !heard_Pa.empty() &&
                   std::abs(heard_Pa.front() - heard_Pa.back()) < 1e-4F * heard_Pa.back();
        };
        EXPECT_TRUE(eventually(isSteady));
    }
};

} // namespace

TEST(PlayedPressure, OfAHeldFieldIsItsOwn)
{
    for (const std::string device : {"sim:", "sim:?ringing=0us"})
    {
        SCOPED_TRACE(device);
        const Played played(device);
        ASSERT_TRUE(played.field && !played.field->getPoints().empty());
        const osg::Vec3d place = played.field->getPoints().front().position;
        const auto pressure_Pa = playedPressure(*played.box.scene, place, 0.02, 5e3);
        ASSERT_EQ(pressure_Pa.size(), 100U);
        const double peak_Pa = std::abs(played.field->getPressures({place}).front());
        const double radiation_Pa = midair::haptics::radiationPressure(peak_Pa, {});
        for (const float each_Pa : pressure_Pa)
            EXPECT_NEAR(each_Pa, radiation_Pa, 1e-3 * radiation_Pa);
    }
}

TEST(PlayedPressure, ASimulationsRingingIsTheScenes)
{
    const Played played("sim:?ringing=276us");
    const auto result = SceneAccess::latestResult(*played.box.scene);
    ASSERT_TRUE(result && result->array);
    EXPECT_EQ(result->array->ringing_s, 276e-6);
}

TEST(PlayedPressure, IsEmptyWhereNothingIsKnown)
{
    const BoxScene fresh;
    EXPECT_TRUE(playedPressure(*fresh.scene, {}).empty()) << "before the first field";
    const Played other("null:");
    EXPECT_TRUE(playedPressure(*other.box.scene, {0.0, 0.0, 0.15}).empty());
    const Played played("sim:");
    const osg::Vec3d place(0.0, 0.0, 0.15);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(playedPressure(*played.box.scene, place, 0.1).empty());
    EXPECT_TRUE(playedPressure(*played.box.scene, place, 0.2).empty());
    EXPECT_TRUE(playedPressure(*played.box.scene, place, 0.0).empty());
    EXPECT_TRUE(playedPressure(*played.box.scene, place, nan).empty());
    EXPECT_TRUE(playedPressure(*played.box.scene, place, 0.05, 2e6).empty());
    EXPECT_TRUE(playedPressure(*played.box.scene, {nan, 0.0, 0.0}).empty());
}

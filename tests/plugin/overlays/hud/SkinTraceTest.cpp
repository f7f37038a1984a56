#include "plugin/overlays/hud/SkinTrace.h"

#include "haptics/array/TransducerArray.h"

#include <memory>

#include <gtest/gtest.h>

using namespace osgMidair;
namespace bridge = midair::bridge;
namespace haptics = midair::haptics;

namespace
{

/// A focus 0.1 m above one transducer that has been on for 50 ms, a field a millisecond.
bridge::HologramResult touchedResult()
{
    haptics::TransducerArray array;
    array.positions = Eigen::Matrix3Xd::Zero(3, 1);
    array.normals = Eigen::Vector3d::UnitZ();
    array.board = {0};
    auto scene = std::make_shared<bridge::ContactScene>();
    bridge::ContactView contact;
    contact.foci = Eigen::Vector3d(0.0, 0.0, 0.1);
    contact.pressure_Pa = Eigen::VectorXd::Constant(1, 100.0);
    scene->contacts = {contact};
    for (int i = 0; i < 50; ++i)
        scene->recent.push_back(std::make_shared<const bridge::TimedField>(
            bridge::TimedField{1.0 + 1e-3 * i, Eigen::VectorXcf::Ones(1)}));
    bridge::HologramResult result;
    result.array = std::make_shared<const haptics::TransducerArray>(array);
    result.touched = scene;
    return result;
}

} // namespace

TEST(SkinTrace, OfAFieldThatStaysIsItsRadiationPressure)
{
    const bridge::HologramResult result = touchedResult();
    const SkinCurve curve = skinCurveOf(result);
    ASSERT_GT(curve.pressure_Pa.size(), 100);
    EXPECT_NEAR(curve.duration_s, 0.048, 1e-3);
    const double steady_Pa = curve.pressure_Pa[curve.pressure_Pa.size() - 1];
    EXPECT_GT(steady_Pa, 0.0);
    for (const double each : curve.pressure_Pa)
        EXPECT_NEAR(each, steady_Pa, 1e-3 * steady_Pa);
}

TEST(SkinTrace, IsOfWhatTheDeviceHasPlayedWhereItKnows)
{
    // Sent for 50 ms, of which the device has played the last 20.
    const bridge::HologramResult result = touchedResult();
    bridge::PlayedDrives played;
    played.until_s = 2.0;
    played.fields = {{1.9, {0.0F}}, {1.98, {1.0F}}};
    const SkinCurve curve = skinCurveOf(result, played);
    ASSERT_EQ(curve.pressure_Pa.size(), 200);
    EXPECT_EQ(curve.pressure_Pa[100], 0.0) << "25 ms ago";
    const SkinCurve sent = skinCurveOf(result);
    const double steady_Pa = sent.pressure_Pa[sent.pressure_Pa.size() - 1];
    EXPECT_NEAR(curve.pressure_Pa[199], steady_Pa, 1e-3 * steady_Pa);
    played.fields.back().q = {1.0F, 1.0F};
    EXPECT_EQ(skinCurveOf(result, played).pressure_Pa.size(), 0) << "of another array";
}

TEST(SkinTrace, IsEmptyWhereNothingIsPlayed)
{
    EXPECT_EQ(skinCurveOf(bridge::HologramResult()).pressure_Pa.size(), 0);
    bridge::HologramResult other = touchedResult();
    auto scene = std::make_shared<bridge::ContactScene>(*other.touched);
    scene->recent.back() = std::make_shared<const bridge::TimedField>(
        bridge::TimedField{2.0, Eigen::VectorXcf::Ones(7)});
    other.touched = scene;
    EXPECT_EQ(skinCurveOf(other).pressure_Pa.size(), 0) << "of another array";
}

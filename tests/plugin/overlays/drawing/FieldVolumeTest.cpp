#include "engine-bridge/pipeline/HologramResult.h"
#include "haptics/propagation/PressureField.h"
#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "plugin/overlays/OverlayPart.h"
#include "plugin/overlays/drawing/FieldSlice.h"

#include <osgMidair/FieldVolumeOverlay>

#include <gtest/gtest.h>

using namespace osgMidair;
namespace haptics = midair::haptics;
namespace bridge = midair::bridge;

namespace
{

VolumeRequest focusedOn(const Eigen::Vector3d& focus)
{
    auto result = std::make_shared<bridge::HologramResult>();
    VolumeRequest request;
    request.array =
        std::make_shared<haptics::TransducerArray>(haptics::TransducerArray::singleBoard());
    const Eigen::VectorXcd g =
        haptics::referencePropagationMatrix(focus, *request.array, request.medium).row(0).adjoint();
    result->frame = 7;
    result->sequence.fields = {(g.array() / g.array().abs()).cast<std::complex<float>>()};
    result->points.positions = focus;
    result->points.normals = Eigen::Vector3d::UnitZ();
    result->points.targets = Eigen::VectorXd::Ones(1);
    result->achieved_Pa = Eigen::VectorXf::Constant(1, static_cast<float>(g.cwiseAbs().sum()));
    request.frame = result->frame;
    request.result = result;
    return request;
}

} // namespace

TEST(FieldVolume, HoldsTheRadiationPressureRoundTheFocus)
{
    const Eigen::Vector3d focus(0.012, -0.007, 0.13);
    const VolumeRequest request = focusedOn(focus);
    const FieldVolume volume = VolumeComputer().compute(request);
    ASSERT_GT(volume.places.size(), 10U);
    ASSERT_EQ(volume.places.size(), volume.colors.size());
    EXPECT_EQ(volume.frame, 7U);
    const auto exact_Pa = [&](const osg::Vec3& at)
    {
        const Eigen::Vector3d place(at.x(), at.y(), at.z());
        const std::complex<double> p =
            (haptics::referencePropagationMatrix(place, *request.array, request.medium) *
             request.result->played().cast<std::complex<double>>())(0);
        return haptics::radiationPressure(std::abs(p), request.medium);
    };
    const double atFocus_Pa = exact_Pa(osg::Vec3(osg::Vec3d(focus.x(), focus.y(), focus.z())));
    for (std::size_t i = 0; i < volume.places.size(); ++i)
    {
        // The lattice's 3e-3 of the pressure count twice.
        EXPECT_NEAR(volume.pressure_Pa[i], exact_Pa(volume.places[i]), 1e-2 * atFocus_Pa);
        EXPECT_GE(volume.pressure_Pa[i], 0.24 * volume.peak_Pa);
        for (int axis = 0; axis < 3; ++axis) // no farther than the margin and a tile
            EXPECT_LT(std::abs(volume.places[i][axis] - focus[axis]), 0.020);
    }
    // A sample is at most half a lattice diagonal from the focus, 2.5 mm: a board's focus is 5 mm
    // wide and longer.
    EXPECT_GT(volume.peak_Pa, 0.6 * atFocus_Pa);
    EXPECT_LE(volume.peak_Pa, 1.02 * atFocus_Pa);
    EXPECT_GE(volume.range_Pa, volume.peak_Pa);
    EXPECT_LE(volume.range_Pa, 1.11F * volume.peak_Pa);
}

TEST(FieldVolume, SilenceDrawsNothingAndKeepsTheScaleOfWhatPlayedBefore)
{
    VolumeRequest sounding = focusedOn({0.012, -0.007, 0.13});
    VolumeRequest silent = sounding;
    auto result = std::make_shared<bridge::HologramResult>(*sounding.result);
    result->sequence.fields.front().setZero();
    result->achieved_Pa.setZero();
    silent.result = result;
    VolumeComputer computer;
    FieldVolume volume = computer.compute(silent);
    EXPECT_TRUE(volume.places.empty());
    EXPECT_EQ(volume.range_Pa, 0.0F);
    const float range_Pa = computer.compute(sounding).range_Pa;
    volume = computer.compute(silent);
    EXPECT_TRUE(volume.places.empty());
    EXPECT_EQ(volume.range_Pa, range_Pa);
}

TEST(FieldVolume, OrdersGoAlongEachAxis)
{
    const FieldVolume volume = VolumeComputer().compute(focusedOn({0.0, 0.0, 0.1}));
    for (int axis = 0; axis < 3; ++axis)
    {
        const auto& order = volume.orders[axis];
        ASSERT_EQ(order.size(), volume.places.size());
        for (std::size_t i = 1; i < order.size(); ++i)
            EXPECT_LE(volume.places[order[i - 1]][axis], volume.places[order[i]][axis]);
    }
}

TEST(FieldVolume, LargeOnesAreCoarser)
{
    VolumeRequest request = focusedOn({0.0, 0.0, 0.15});
    auto result = std::make_shared<bridge::HologramResult>(*request.result);
    result->points.positions.resize(3, 2);
    result->points.positions << -0.2, 0.2, -0.2, 0.2, 0.05, 0.25;
    request.result = result;
    const FieldVolume volume = VolumeComputer().compute(request);
    EXPECT_GT(volume.pitch_m, 0.005);
}

TEST(FieldVolumeOverlay, ShowsTheNewestFieldWithoutWaiting)
{
    const VolumeRequest request = focusedOn({0.0, 0.01, 0.12});
    osg::ref_ptr<FieldVolumeOverlay> overlay = new FieldVolumeOverlay;
    OverlayPart::of(*overlay).setResult(
        request.result); // before it knows an array: nothing to show
    EXPECT_FALSE(overlay->waitFor(7, 0.0));
    OverlayPart::of(*overlay).setArray(request.array, request.medium);
    OverlayPart::of(*overlay).setResult(request.result);
    ASSERT_TRUE(overlay->waitFor(7, 60.0));
    EXPECT_EQ(overlay->getShownFrame(), 7U);
    EXPECT_GT(overlay->getRange(), 0.0F);
}

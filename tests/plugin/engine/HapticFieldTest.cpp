#include "engine-bridge/scene/Convert.h"
#include "haptics/array/TransducerArray.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "tests/plugin/KitTest.h"

#include <osgMidair/HapticCallback>
#include <osgMidair/HapticField>

#include <algorithm>
#include <atomic>
#include <limits>
#include <thread>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

osg::ref_ptr<const HapticField> played(HeadlessViewer& viewer, const BoxScene& box)
{
    osg::ref_ptr<const HapticField> field;
    viewer.framesUntil(
        [&]
        {
            field = box.scene->getField();
            return field && !field->getPoints().empty();
        });
    return field;
}

std::vector<osg::Vec3d> placesOf(const HapticField& field)
{
    std::vector<osg::Vec3d> places;
    for (const HapticField::ControlPoint& point : field.getPoints())
        places.push_back(point.position);
    return places;
}

} // namespace

TEST(HapticField, IsNullBeforeTheFirstField)
{
    const BoxScene box;
    EXPECT_EQ(box.scene->getField(), nullptr);
    const osg::ref_ptr<HapticCallback> callback = new HapticCallback;
    EXPECT_EQ(callback->getField(), nullptr);
}

// A scene in millimetres, moved and turned against its array: points come back where the box is
// drawn, and belong to it.
TEST(HapticField, PointsAreWhereTheSceneIsDrawn)
{
    const osg::Vec3d middle(20.0, -30.0, 500.0);
    BoxScene box;
    box.transform->setMatrix(osg::Matrixd::scale(1e3, 1e3, 1e3) * osg::Matrixd::translate(middle));
    box.scene->setMetresPerUnit(1e-3);
    box.scene->setCalibration(osg::Matrixd::translate(middle * -1e-3) *
                              osg::Matrixd::rotate(0.5, osg::Z_AXIS) *
                              osg::Matrixd::translate(0.0, 0.0, 0.15));
    HeadlessViewer viewer(box.scene);
    const auto field = played(viewer, box);
    ASSERT_TRUE(field);
    ASSERT_EQ(field->getPoints().size(), static_cast<std::size_t>(box.points()));
    for (const HapticField::ControlPoint& point : field->getPoints())
    {
        const osg::Vec3d off = point.position - middle;
        const double farthest = std::max({std::abs(off.x()), std::abs(off.y()), std::abs(off.z())});
        EXPECT_NEAR(farthest, 20.0, 1e-6) << "on the skin of a box of 40 mm";
        EXPECT_NEAR(point.normal.length(), 1.0, 1e-9);
        EXPECT_GT(point.normal * off, 0.0) << "out of the box";
        EXPECT_NEAR(point.achieved_Pa / point.wanted_Pa, 1.0, 0.1);
        ASSERT_LT(point.object, field->getObjects().size());
        osg::ref_ptr<osg::Node> node;
        ASSERT_TRUE(field->getObjects()[point.object].node.lock(node));
        EXPECT_EQ(node, box.surface);
        EXPECT_NE(field->getObjects()[point.object].path.find("box"), std::string::npos);
    }
}

TEST(HapticField, PressuresAreThoseOfTheReferenceInDouble)
{
    BoxScene box;
    HeadlessViewer viewer(box.scene);
    const auto field = played(viewer, box);
    ASSERT_TRUE(field);
    const auto array = midair::haptics::TransducerArray::singleBoard();
    std::vector<osg::Vec3d> places = placesOf(*field);
    for (int k = 0; k < 30; ++k)
        places.emplace_back(0.05 * std::sin(2.1 * k), 0.05 * std::cos(1.3 * k), 0.1 + 0.003 * k);
    Eigen::Matrix3Xd there(3, static_cast<Eigen::Index>(places.size()));
    for (std::size_t i = 0; i < places.size(); ++i)
        there.col(static_cast<Eigen::Index>(i)) = midair::bridge::toEigen(places[i]);
    const Eigen::MatrixXcd G = midair::haptics::referencePropagationMatrix(there, array, {});
    const auto drive = field->getActivations();
    ASSERT_EQ(drive.size(), 249u);
    const Eigen::VectorXcd q =
        Eigen::Map<const Eigen::VectorXcf>(drive.data(), 249).cast<std::complex<double>>();
    const Eigen::VectorXcd expected = G * q;
    const Eigen::VectorXd inPhase = G.cwiseAbs() * q.cwiseAbs();
    const auto pressures = field->getPressures(places);
    const auto felt = field->getFeltPressures(places);
    ASSERT_EQ(pressures.size(), places.size());
    for (std::size_t i = 0; i < places.size(); ++i)
    {
        const auto l = static_cast<Eigen::Index>(i);
        EXPECT_LE(std::abs(std::complex<double>(pressures[i]) - expected[l]), 1e-5 * inPhase[l]);
        EXPECT_NEAR(felt[i], std::abs(pressures[i]), 2e-5 * inPhase[l]);
        if (i < field->getPoints().size())
        {
            EXPECT_NEAR(
                std::abs(pressures[i]), field->getPoints()[i].achieved_Pa, 1e-4 * inPhase[l]);
        }
    }
    EXPECT_EQ(field->getPressure(places[0]), pressures[0]);
    EXPECT_NEAR(field->getWavelength(), 8.58e-3, 1e-5);
}

TEST(HapticField, FieldsInTurnAreThereOneByOne)
{
    BoxScene box;
    box.scene->setSubsets(3);
    HeadlessViewer viewer(box.scene);
    const auto field = played(viewer, box);
    ASSERT_TRUE(field);
    ASSERT_EQ(field->getNumFields(), 3u);
    EXPECT_EQ(field->getFieldRate(), 1000.0);
    std::vector<int> points(3);
    for (const HapticField::ControlPoint& point : field->getPoints())
    {
        ASSERT_LT(point.field, 3u);
        ++points[point.field];
        EXPECT_NEAR(std::abs(field->getPressure(point.position, point.field)),
                    point.achieved_Pa,
                    0.01 * point.achieved_Pa + 1.0);
    }
    EXPECT_GT(*std::min_element(points.begin(), points.end()), 0);
    EXPECT_NE(field->getActivations(0), field->getActivations(1));
    const std::vector<osg::Vec3d> places = placesOf(*field);
    const float felt = field->getFeltPressures({places[0]}).front();
    double square = 0.0;
    for (unsigned int k = 0; k < 3; ++k)
        square += std::norm(field->getPressure(places[0], k)) / 3.0;
    EXPECT_NEAR(felt, std::sqrt(square), 1e-3 * felt + 0.1);
    EXPECT_TRUE(field->getActivations(3).empty());
    EXPECT_EQ(field->getPressure(places[0], 3), std::complex<float>());
}

TEST(HapticField, SaysWhetherADevicePlaysItAndStaysAsItIs)
{
    BoxScene box;
    HeadlessViewer viewer(box.scene);
    const auto field = played(viewer, box);
    ASSERT_TRUE(field);
    EXPECT_TRUE(field->isPlaying());
    EXPECT_EQ(box.scene->getField(), field) << "the same until there is a newer one";
    EXPECT_GT(field->getHandedOverTime(), 0.0);
    const std::size_t points = field->getPoints().size();
    box.scene->setEnabled(false);
    ASSERT_TRUE(viewer.framesUntil([&] { return box.points() == 0; }));
    const auto silence = box.scene->getField();
    ASSERT_TRUE(silence);
    EXPECT_NE(silence, field);
    EXPECT_FALSE(silence->isPlaying());
    EXPECT_EQ(silence->getPressure({0, 0, 0.15}), std::complex<float>());
    EXPECT_EQ(field->getPoints().size(), points);
    EXPECT_GT(std::abs(field->getPressure(field->getPoints()[0].position)), 0.0F);
}

TEST(HapticField, IsNotPlayedByADeviceThatLosesAllItTakes)
{
    BoxScene box;
    box.scene->setDevice("sim:?drop=1");
    HeadlessViewer viewer(box.scene);
    // Each frame has another field, and no time to wait for what became of the last one.
    double loudness = 0.5;
    const auto isFaulty = [&]
    {
        box.scene->setLoudness(loudness += 1e-4);
        const auto result = box.result();
        return result && result->playing && result->state == ArrayState::FAULT;
    };
    ASSERT_TRUE(viewer.framesUntil(isFaulty));
    EXPECT_FALSE(box.scene->getField()->isPlaying());
}

TEST(HapticField, WithoutADeviceItIsSolvedForButNotPlayed)
{
    BoxScene box;
    box.scene->setDevice("nosuchdevice:");
    HeadlessViewer viewer(box.scene);
    const auto field = played(viewer, box);
    ASSERT_TRUE(field);
    EXPECT_FALSE(field->isPlaying());
    EXPECT_GT(field->getPoints()[0].achieved_Pa, 0.0);
}

TEST(HapticField, OutlivesTheSceneAndItsNodes)
{
    osg::ref_ptr<const HapticField> field;
    {
        BoxScene box;
        HeadlessViewer viewer(box.scene);
        field = played(viewer, box);
    }
    ASSERT_TRUE(field);
    osg::ref_ptr<osg::Node> node;
    EXPECT_FALSE(field->getObjects()[0].node.lock(node));
    EXPECT_GT(std::abs(field->getPressure(field->getPoints()[0].position)), 0.0F);
    EXPECT_EQ(field->getArray()->transducers.size(), 249u);
}

// Against a sum of p^2 / (rho c^2) over a fine grid; air of 20 degrees.
TEST(HapticField, TheForceOnAFingertipIsThatOnADiscOf14Millimetres)
{
    BoxScene box;
    HeadlessViewer viewer(box.scene);
    const auto field = played(viewer, box);
    ASSERT_TRUE(field);
    const HapticField::ControlPoint& point = field->getPoints()[0];
    ASSERT_GT(point.normal.length(), 0.5);
    osg::Vec3d across = point.normal ^ osg::Vec3d(0.3, 0.5, 0.8);
    across.normalize();
    const osg::Vec3d along = point.normal ^ across;
    constexpr double kStep_m = 0.25e-3;
    std::vector<osg::Vec3d> places;
    for (double x = -0.007; x <= 0.007; x += kStep_m)
        for (double y = -0.007; y <= 0.007; y += kStep_m)
            if (x * x + y * y <= 0.007 * 0.007)
                places.push_back(point.position + across * x + along * y);
    double sum_Pa2 = 0.0;
    for (const float pressure : field->getFeltPressures(places))
        sum_Pa2 += static_cast<double>(pressure) * pressure;
    const double expected_N = sum_Pa2 * kStep_m * kStep_m / (1.204 * 343.2 * 343.2);
    ASSERT_GT(expected_N, 1e-5);
    EXPECT_NEAR(
        field->getFingertipForce(point.position, point.normal), expected_N, 0.05 * expected_N);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(field->getFingertipForce({nan, 0, 0}, point.normal), 0.0);
    EXPECT_EQ(field->getFingertipForce(point.position, {0, nan, 0}), 0.0);
    EXPECT_GT(field->getFingertipForce(point.position, {}), 0.0);
}

TEST(HapticField, PlacesThatAreNotFiniteHaveNoPressure)
{
    BoxScene box;
    HeadlessViewer viewer(box.scene);
    const auto field = played(viewer, box);
    ASSERT_TRUE(field);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const osg::Vec3d good = field->getPoints()[0].position;
    const auto pressures = field->getPressures({{nan, 0, 0}, good, {0, 1.0 / 0.0, 0}});
    EXPECT_EQ(pressures[0], std::complex<float>());
    EXPECT_GT(std::abs(pressures[1]), 0.0F);
    EXPECT_EQ(pressures[2], std::complex<float>());
    EXPECT_EQ(field->getFeltPressures({{nan, 0, 0}}), std::vector<float>{0.0F});
    EXPECT_TRUE(field->getPressures({}).empty());
}

TEST(HapticField, AnyThreadMayAskWhileTheSceneGoesOn)
{
    BoxScene box;
    HeadlessViewer viewer(box.scene);
    ASSERT_TRUE(played(viewer, box));
    std::atomic<bool> done{false};
    std::atomic<int> wrong{0};
    std::thread reader(
        [&]
        {
            while (!done)
            {
                const auto field = box.scene->getField();
                if (field && !field->getPoints().empty() &&
                    !(std::abs(field->getPressure(field->getPoints()[0].position)) > 0.0F))
                    ++wrong;
            }
        });
    for (int k = 0; k < 20; ++k)
    {
        const std::uint64_t solves = box.scene->getStatistics().solves;
        box.move(1e-3 * (k + 1));
        EXPECT_TRUE(viewer.framesUntil([&] { return box.scene->getStatistics().solves > solves; }));
    }
    done = true;
    reader.join();
    EXPECT_EQ(wrong, 0);
}

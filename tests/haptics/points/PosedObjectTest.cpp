#include "haptics/points/ControlPointSelector.h"
#include "tests/haptics/surface/SampleMeshes.h"

#include <gtest/gtest.h>

namespace midair::haptics
{

namespace
{

PosedObject ball(std::uint64_t first)
{
    PosedObject object;
    object.pose(sampleSurface(test::sphere(0.02, 3), {}), Eigen::Isometry3d::Identity(), first);
    return object;
}

} // namespace

TEST(PosedObject, CountsItsSamplesFromTheFirst)
{
    const PosedObject object = ball(1000);
    ASSERT_EQ(static_cast<Eigen::Index>(object.identity.size()), object.positions.cols());
    for (std::size_t i = 0; i < object.identity.size(); ++i)
        EXPECT_EQ(object.identity[i], 1000 + i);
}

TEST(PosedObject, KeepsTheSamplesThatItIsToldTo)
{
    const PosedObject whole = ball(1000);
    PosedObject half = whole;
    half.intensity = Eigen::VectorXf::LinSpaced(whole.positions.cols(), 0.0f, 1.0f);
    const Eigen::VectorXf intensity = half.intensity;
    half.keepIf([](Eigen::Index i) { return i % 2 == 1; });
    ASSERT_EQ(half.positions.cols(), whole.positions.cols() / 2);
    ASSERT_EQ(half.identity.size(), static_cast<std::size_t>(half.positions.cols()));
    for (Eigen::Index i = 0; i < half.positions.cols(); ++i)
    {
        const Eigen::Index from = 2 * i + 1;
        EXPECT_EQ(half.identity[static_cast<std::size_t>(i)],
                  1000 + static_cast<std::uint64_t>(from));
        EXPECT_EQ(half.positions.col(i), whole.positions.col(from));
        EXPECT_EQ(half.normals.col(i), whole.normals.col(from));
        EXPECT_EQ(half.intensity[i], intensity[from]);
    }
}

TEST(PosedObject, SelectedPointsHaveTheIdentityOfTheirSample)
{
    const TransducerArray array = TransducerArray::octagonalPrism();
    const SelectorOptions options;
    const Workspace workspace(array, 8.6e-3, options);
    std::vector<PosedObject> objects{ball(1000), ball(5000)};
    objects[1].positions.row(0).array() += 0.035; // some are too near to the other's
    const Selection selection = selectControlPoints(objects, workspace, options);
    ASSERT_EQ(selection.points.identity.size(), selection.source.size());
    ASSERT_LT(selection.points.size(), objects[0].positions.cols() + objects[1].positions.cols());
    for (std::size_t k = 0; k < selection.source.size(); ++k)
        EXPECT_EQ(selection.points.identity[k],
                  (selection.source[k] == 0 ? 1000u : 5000u) +
                      static_cast<std::uint64_t>(selection.sample[k]));

    objects[1].identity.clear();
    EXPECT_TRUE(selectControlPoints(objects, workspace, options).points.identity.empty())
        << "all of them or none";
    objects[1].identity.assign(3, 0);
    EXPECT_THROW(selectControlPoints(objects, workspace, options), std::exception);
}

} // namespace midair::haptics

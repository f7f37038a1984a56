#include "haptics/sequence/FieldMonitor.h"

#include "haptics/base/InputError.h"
#include "tests/Eventually.h"
#include "tests/haptics/surface/SampleMeshes.h"

#include <chrono>
#include <cmath>

#include <gtest/gtest.h>

using namespace midair::haptics;

namespace
{

using namespace std::chrono_literals;

std::shared_ptr<PlayedField> field(std::uint64_t number)
{
    auto result = std::make_shared<PlayedField>();
    result->points.positions.resize(3, 3);
    result->points.positions << 0.0, 0.02, -0.02, //
        0.0, 0.01, 0.01,                          //
        0.15, 0.15, 0.16;
    result->points.normals = Eigen::Vector3d::UnitZ().replicate(1, 3);
    result->points.targets = Eigen::VectorXd::Ones(3);
    result->array = std::make_shared<const TransducerArray>(TransducerArray::singleBoard());
    result->q = Eigen::VectorXcf::Ones(result->array->size());
    result->number = number;
    return result;
}

// Waits until a field of at least that number is certified.
std::shared_ptr<const FieldMonitor::Result> resultOf(const FieldMonitor& monitor,
                                                     std::uint64_t number)
{
    // The monitor runs only when nobody else wants to.
    std::shared_ptr<const FieldMonitor::Result> result;
    const bool isThere = eventually(
        [&]
        {
            result = monitor.latest();
            return result && result->number >= number;
        },
        300.0);
    return isThere ? result : nullptr;
}

} // namespace

TEST(FieldMonitor, GivesWhatTheCertifierGives)
{
    FieldMonitor::Options options;
    options.interval_s = 0.0;
    FieldMonitor monitor(options);
    EXPECT_EQ(monitor.latest(), nullptr);
    const auto played = field(7);
    monitor.submit(played);
    const auto result = resultOf(monitor, 7);
    ASSERT_NE(result, nullptr);
    EXPECT_EQ(result->error, "");
    EXPECT_EQ(result->number, 7u);
    const Certificate direct =
        Certifier().certify(played->points, *played->array, played->medium, played->q);
    EXPECT_EQ(result->certificate.bound, direct.bound);
    EXPECT_EQ(result->certificate.best, direct.best);
    EXPECT_EQ(result->certificate.givenField, direct.givenField);
    EXPECT_GE(result->certificate.gapOfField(), 0.0);
}

TEST(FieldMonitor, TakesTheNewestAndNeverMakesTheCallerWait)
{
    FieldMonitor::Options options;
    options.interval_s = 0.0;
    FieldMonitor monitor(options);
    // Many more than can be certified in the time: those in between are dropped, the last is not.
    constexpr std::uint64_t kFields = 20000;
    const auto shared = field(0);
    for (std::uint64_t i = 1; i <= kFields; ++i)
    {
        auto next = std::make_shared<PlayedField>(*shared);
        next->number = i;
        monitor.submit(next);
    }
    const auto last = resultOf(monitor, kFields);
    ASSERT_NE(last, nullptr);
    EXPECT_EQ(last->number, kFields);
}

TEST(FieldMonitor, MeasuresTheSurfaceThatIsFelt)
{
    FieldMonitor::Options options;
    options.interval_s = 0.0;
    options.certify = false;
    FieldMonitor monitor(options);
    auto played = field(1);
    FeltSurface disc;
    disc.mesh = std::make_shared<const TriangleMesh>(test::disc(0.02, 40));
    disc.pose.translation() = Eigen::Vector3d(0.0, 0.0, 0.15);
    played->surfaces = {disc};
    monitor.submit(played);
    const auto whole = resultOf(monitor, 1);
    ASSERT_NE(whole, nullptr);
    EXPECT_EQ(whole->error, "");
    EXPECT_EQ(whole->certificate.points, 0) << "not asked for";
    // Samples 0.18 wavelengths apart at least, on pi (20 mm)^2.
    EXPECT_GT(whole->surface.samples, 200);
    EXPECT_GT(whole->surface.contrast, 0.0);

    // Only what is within 3 mm of the first point, which stands in the middle of the disc; half as
    // loud in turn with silence.
    auto part = field(2);
    disc.reach_m = 0.003;
    part->points.positions.resize(3, 1);
    part->points.positions.col(0) = disc.pose.translation();
    part->points.targets.setOnes(1);
    part->surfaces = {disc};
    monitor.submit(part);
    const auto near = resultOf(monitor, 2);
    ASSERT_NE(near, nullptr);
    EXPECT_LT(near->surface.samples, whole->surface.samples / 10);
    EXPECT_GT(near->surface.samples, 0);
    auto turns = std::make_shared<PlayedField>(*part);
    turns->cycle = {turns->q, Eigen::VectorXcf::Zero(turns->q.size())};
    turns->number = 3;
    monitor.submit(turns);
    const auto half = resultOf(monitor, 3);
    ASSERT_NE(half, nullptr);
    EXPECT_NEAR(half->surface.mean_Pa, 0.5 * near->surface.mean_Pa, 1e-6 * near->surface.mean_Pa);
}

TEST(FieldMonitor, SaysWhyAFieldCannotBeCertifiedAndGoesOn)
{
    FieldMonitor::Options options;
    options.interval_s = 0.0;
    FieldMonitor monitor(options);
    auto bad = field(1);
    bad->points.targets[1] = std::nan("");
    monitor.submit(bad);
    const auto refused = resultOf(monitor, 1);
    ASSERT_NE(refused, nullptr);
    EXPECT_EQ(refused->error,
              "phase objective: targets must be finite and at least 0, one of them more");
    auto none = field(2);
    none->array.reset();
    monitor.submit(none);
    const auto without = resultOf(monitor, 2);
    ASSERT_NE(without, nullptr);
    EXPECT_EQ(without->error, "field monitor: the field has no array");
    monitor.submit(field(3));
    const auto good = resultOf(monitor, 3);
    ASSERT_NE(good, nullptr);
    EXPECT_EQ(good->error, "");
}

TEST(FieldMonitor, WaitsOutItsIntervalAndEndsAtOnce)
{
    FieldMonitor::Options options;
    options.interval_s = 1000.0;
    const auto start = std::chrono::steady_clock::now();
    {
        FieldMonitor monitor(options);
        monitor.submit(field(1));
        ASSERT_NE(resultOf(monitor, 1), nullptr);
        monitor.submit(field(2));
        EXPECT_FALSE(monitor.isWaiting());
        letPass(0.02);
        EXPECT_EQ(monitor.latest()->number, 1u);
    }
    EXPECT_LT(std::chrono::steady_clock::now() - start, 60s); // not the thousand seconds
    options.interval_s = -1.0;
    EXPECT_THROW(FieldMonitor{options}, midair::base::InputError);
}

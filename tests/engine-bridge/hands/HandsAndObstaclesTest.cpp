
#include "engine-bridge/hands/Obstacles.h"
#include "engine-bridge/pipeline/HologramPipeline.h"
#include "haptics/propagation/PropagationMatrix.h"
#include "haptics/propagation/ReferencePropagation.h"

#include <cmath>

#include <gtest/gtest.h>

namespace midair::bridge
{

namespace
{

using Eigen::Vector3d;

/// What the solver was last given.
struct Seen
{
    int solves = 0;
    haptics::ControlPoints points;
    haptics::TransducerArray array;
};

class WatchedSolver : public haptics::HologramSolver
{
public:
    explicit WatchedSolver(std::shared_ptr<Seen> seen) : _seen(std::move(seen)) {}

    haptics::SolveReport solve(const haptics::ControlPoints& points,
                               const haptics::TransducerArray& array,
                               const haptics::Medium& /*medium*/,
                               Eigen::VectorXcf& q) override
    {
        ++_seen->solves;
        _seen->points = points;
        _seen->array = array;
        q.setOnes(array.size());
        haptics::SolveReport report;
        report.stop = haptics::StopReason::CONVERGED;
        return report;
    }

    const haptics::SolverOptions& options() const override { return _options; }

private:
    std::shared_ptr<Seen> _seen;
    haptics::SolverOptions _options;
};

HologramOptions watched(const std::shared_ptr<Seen>& seen)
{
    HologramOptions options;
    options.array = haptics::TransducerArray::octagonalPrism();
    options.deviceUri = "null:";
    options.solverFactory = [seen](const std::string&, const haptics::SolverOptions&)
    { return std::make_unique<WatchedSolver>(seen); };
    return options;
}

/// A square of 80 mm in z = 0.
SceneSnapshot squareScene()
{
    auto mesh = std::make_shared<haptics::TriangleMesh>();
    mesh->vertices.resize(3, 4);
    mesh->vertices << -0.04, 0.04, 0.04, -0.04, -0.04, -0.04, 0.04, 0.04, 0, 0, 0, 0;
    mesh->triangles.resize(3, 2);
    mesh->triangles << 0, 0, 1, 2, 2, 3;
    SceneSnapshot snapshot;
    HapticObject object;
    object.id = 1;
    object.path = "square";
    object.meshId = 1;
    object.mesh = mesh;
    snapshot.objects.push_back(object);
    return snapshot;
}

HandCapsule fingerAt(double x)
{
    return {{Vector3d(x, 0, 0.01), Vector3d(x, 0, 0.03), 0.008}, 1, 7};
}

TEST(HandsAndObstacles, OnlyWhatMattersCounts)
{
    HandsAndObstacles a;
    HandsAndObstacles b;
    b.hands = {fingerAt(0.0)};
    EXPECT_TRUE(equivalent(a, b)); // hands that nobody asked about
    a.reach_m = b.reach_m = 0.02;
    EXPECT_FALSE(equivalent(a, b));
    a.hands = {fingerAt(0.5e-3)};
    EXPECT_TRUE(equivalent(a, b));
    a.hands = {fingerAt(1.5e-3)};
    EXPECT_FALSE(equivalent(a, b));
    a.hands = {fingerAt(NAN)};
    EXPECT_FALSE(equivalent(a, a));
    a = b;
    a.props = {{Vector3d::Zero(), Vector3d::Zero(), 0.01}};
    EXPECT_TRUE(equivalent(a, b)); // props only shadow
    a.shadows = b.shadows = true;
    EXPECT_FALSE(equivalent(a, b));
}

TEST(HandsAndObstacles, OnlyPointsWithinReachAreSolved)
{
    const auto seen = std::make_shared<Seen>();
    HologramPipeline pipeline(watched(seen));
    SceneSnapshot snapshot = squareScene();
    const int all = pipeline.process(snapshot)->points.size();
    ASSERT_GT(all, 50);

    snapshot.around.reach_m = 0.015;
    snapshot.around.hands = {fingerAt(0.03)};
    const auto near = pipeline.process(snapshot);
    EXPECT_EQ(seen->solves, 2);
    EXPECT_GT(near->points.size(), 3);
    EXPECT_LT(near->points.size(), all / 2);
    EXPECT_EQ(near->points.size() + near->skipped.cols(), all);
    EXPECT_EQ(near->counters.outOfReach, static_cast<std::uint64_t>(near->skipped.cols()));
    for (const auto& point : near->points.positions.colwise())
        EXPECT_LE((point - Vector3d(0.03, 0, 0.01)).norm(), 0.023 + 1e-12);
    for (const auto& point : near->skipped.colwise())
        EXPECT_GT((point - Vector3d(0.03, 0, 0.01)).norm(), 0.023);

    pipeline.process(snapshot);
    EXPECT_EQ(seen->solves, 2); // neither object nor hand moved
    snapshot.around.hands = {fingerAt(0.032)};
    pipeline.process(snapshot);
    EXPECT_EQ(seen->solves, 3);
}

TEST(HandsAndObstacles, NoHandWithinReachMeansSilence)
{
    const auto seen = std::make_shared<Seen>();
    HologramPipeline pipeline(watched(seen));
    SceneSnapshot snapshot = squareScene();
    snapshot.around.reach_m = 0.02;
    const auto result = pipeline.process(snapshot);
    EXPECT_EQ(seen->solves, 0);
    EXPECT_EQ(result->points.size(), 0);
    EXPECT_EQ(result->report().stop, haptics::StopReason::NOTHING_TO_DO);
    EXPECT_EQ(result->played().cwiseAbs().maxCoeff(), 0.0f);
    EXPECT_GT(result->skipped.cols(), 50);
}

TEST(HandsAndObstacles, ShadowedTransducersHaveLowerGain)
{
    const auto seen = std::make_shared<Seen>();
    HologramOptions options = watched(seen);
    options.array.gain = Eigen::VectorXd::Constant(options.array.size(), 0.9);
    HologramPipeline pipeline(options);
    SceneSnapshot snapshot = squareScene();
    snapshot.around.hands = {fingerAt(0.0)};
    pipeline.process(snapshot);
    EXPECT_EQ(seen->array.gain, options.array.gain);
    snapshot.around.shadows = true;
    snapshot.around.props = {
        {Vector3d(-0.1, 0, 0.1), Vector3d(0.1, 0, 0.1), 0.03}}; // a rod over the square
    pipeline.process(snapshot);
    EXPECT_EQ(seen->solves, 2);
    EXPECT_LT(seen->array.gain.minCoeff(), 0.5);
    EXPECT_NEAR(seen->array.gain.maxCoeff(), 0.9, 1e-12);
    // The darkest transducers are those above the rod, seen from the square.
    Eigen::Index darkest = 0;
    seen->array.gain.minCoeff(&darkest);
    EXPECT_GT(options.array.positions(2, darkest), 0.1);
    snapshot.around.props.clear();
    snapshot.around.hands.clear();
    pipeline.process(snapshot);
    EXPECT_EQ(seen->array.gain, options.array.gain);
}

/// Relative rms error of |p| at \a points where obstacles shadow every way, with \a q played.
double errorBehind(const std::vector<Capsule>& obstacles,
                   const haptics::ControlPoints& points,
                   const haptics::TransducerArray& array,
                   const Eigen::VectorXcf& q)
{
    const haptics::Medium medium;
    const Eigen::MatrixXd W =
        shadowWeights(points.positions, array, obstacles, medium.wavelength(array.frequency_Hz));
    const Eigen::MatrixXcd G = haptics::referencePropagationMatrix(points.positions, array, medium)
                                   .cwiseProduct(W.cast<std::complex<double>>());
    const Eigen::VectorXd y = (G * q.cast<std::complex<double>>()).cwiseAbs();
    const double s = y.dot(points.targets) / points.targets.squaredNorm();
    return std::sqrt((y.array() / (s * points.targets.array()) - 1.0).square().mean());
}

/// Twenty points spread over a ball of 20 mm: a spiral from pole to pole.
haptics::ControlPoints ball()
{
    haptics::ControlPoints points;
    points.normals.resize(3, 20);
    for (int l = 0; l < 20; ++l)
    {
        const double z = 1.0 - 2.0 * (l + 0.5) / 20.0;
        const double ring = std::sqrt(1.0 - z * z);
        points.normals.col(l) = Vector3d(ring * std::cos(2.4 * l), ring * std::sin(2.4 * l), z);
    }
    points.positions = 0.02 * points.normals;
    points.targets.setOnes(20);
    return points;
}

TEST(HandsAndObstacles, FieldsThatKnowTheShadowAreMoreEvenBehindAnArm)
{
    const haptics::TransducerArray array = haptics::TransducerArray::octagonalPrism();
    const haptics::ControlPoints points = ball();
    const haptics::Medium medium;
    double without = 0.0;
    double with = 0.0;
    for (const double height : {0.03, 0.05, 0.08, 0.12})
    {
        HandsAndObstacles around;
        around.props = {{Vector3d(-0.15, 0, height), Vector3d(0.15, 0, height), 0.035}};
        around.shadows = true;
        ReachAndShadow effect;
        effect.begin(around);
        Eigen::VectorXcf q;
        haptics::makeSolver("gs")->solve(points, array, medium, q);
        without += errorBehind(around.props, points, array, q) / 4.0;
        const double wavelength = medium.wavelength(array.frequency_Hz);
        haptics::makeSolver("gs")->solve(
            points, effect.shadowed(points, array, wavelength), medium, q);
        with += errorBehind(around.props, points, array, q) / 4.0;
    }
    // One gain a transducer can't follow shadows that differ from point to point, so it does not
    // win everywhere; over balls behind arms it takes away a third of the error or more.
    EXPECT_LT(with, 0.8 * without) << without;
}

} // namespace

} // namespace midair::bridge

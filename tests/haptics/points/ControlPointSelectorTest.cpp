#include "haptics/points/ControlPointSelector.h"

#include "haptics/base/InputError.h"
#include "tests/haptics/points/LeftOutSums.h"
#include "tests/haptics/surface/SampleMeshes.h"

#include <algorithm>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

namespace midair::haptics
{

namespace
{

constexpr double kWavelength = 8.6e-3;

PosedObject objectOf(int id, int priority, const std::vector<Eigen::Vector3d>& points)
{
    PosedObject object;
    object.object = id;
    object.priority = priority;
    object.spacing_m = kWavelength;
    object.positions.resize(3, static_cast<Eigen::Index>(points.size()));
    for (std::size_t i = 0; i < points.size(); ++i)
        object.positions.col(static_cast<Eigen::Index>(i)) = points[i];
    object.normals = Eigen::Vector3d::UnitZ().replicate(1, object.positions.cols());
    return object;
}

PosedObject ball(int id,
                 int priority,
                 double radius,
                 const Eigen::Vector3d& centre,
                 double spacing = kWavelength)
{
    SamplerOptions options;
    options.spacing_m = spacing;
    const SurfaceSamples samples = sampleSurface(test::sphere(radius, 3), options);
    PosedObject object;
    object.object = id;
    object.priority = priority;
    object.spacing_m = spacing;
    object.pose(samples, Eigen::Isometry3d(Eigen::Translation3d(centre)));
    return object;
}

struct ControlPointSelector : testing::Test
{
    Selection select(const std::vector<PosedObject>& objects)
    {
        const Selection selection =
            selectControlPoints(objects, Workspace(array, kWavelength, options), options);
        const SelectionReport& r = selection.report;
        EXPECT_EQ(r.candidates,
                  r.selected + r.notFinite + r.noTarget + r.tooClose + r.behind + r.atReflector +
                      r.outOfReach + r.spacedOut + r.crowdThinned + r.crowdMerged + r.crowdDropped +
                      r.overBudget);
        test::expectLeftOutAddsUp(objects, r);
        EXPECT_EQ(r.selected, selection.points.size());
        EXPECT_EQ(std::accumulate(r.perObject.begin(), r.perObject.end(), 0), r.selected);
        EXPECT_EQ(static_cast<int>(selection.points.object.size()), r.selected);
        EXPECT_EQ(selection.points.targets.size(), r.selected);
        EXPECT_EQ(selection.points.normals.cols(), r.selected);
        EXPECT_TRUE(selection.points.positions.allFinite());
        return selection;
    }

    TransducerArray array = TransducerArray::octagonalPrism();
    SelectorOptions options;
};

} // namespace

TEST_F(ControlPointSelector, LeavesOneObjectAsItIs)
{
    PosedObject object = ball(7, 0, 0.03, {0.01, 0.02, 0.0});
    object.target = 2.0;
    object.intensity.setConstant(0.5F);
    const Selection selection = select({object});
    EXPECT_EQ(selection.points.positions, object.positions);
    EXPECT_EQ(selection.points.normals, object.normals);
    EXPECT_TRUE((selection.points.targets.array() == 1.0).all());
    EXPECT_TRUE(std::all_of(selection.points.object.begin(),
                            selection.points.object.end(),
                            [](int o) { return o == 7; }));
    for (int i = 0; i < selection.points.size(); ++i)
    {
        EXPECT_EQ(selection.sample[static_cast<std::size_t>(i)], i);
    }
    EXPECT_EQ(selection.report.summary(), "");
}

TEST_F(ControlPointSelector, TakesNoObjectsAndNoPoints)
{
    EXPECT_EQ(select({}).points.size(), 0);
    EXPECT_EQ(select({objectOf(1, 0, {})}).points.size(), 0);
}

TEST_F(ControlPointSelector, LeavesOutWhatCantBePlayed)
{
    const double nan = std::nan("");
    PosedObject object =
        objectOf(1,
                 0,
                 {{0, 0, 0},
                  {nan, 0, 0},
                  {0, std::numeric_limits<double>::infinity(), 0},
                  {0.05, 0, 0},
                  {0, 10, 0},
                  {1e300, 0, 0},
                  {0.30, 0, 0},
                  {0.5, 0.1, 0.3},
                  {array.positions(0, 0), array.positions(1, 0), array.positions(2, 0)}});
    object.intensity = Eigen::VectorXf::Ones(object.positions.cols());
    object.intensity[3] = 0.0F;
    const Selection selection = select({object});
    EXPECT_EQ(selection.report.notFinite, 2);
    EXPECT_EQ(selection.report.noTarget, 1);
    EXPECT_EQ(selection.report.outOfReach, 2);
    EXPECT_EQ(selection.report.behind, 2);
    EXPECT_EQ(selection.report.tooClose, 1);
    EXPECT_EQ(selection.points.size(), 1);
    EXPECT_EQ(selection.report.summary(),
              "1 of 9 points: 2 not finite, 1 without a positive target, 2 out of reach, 2 behind "
              "the array, 1 too close to a transducer");
}

TEST_F(ControlPointSelector, LeavesOutTargetsThatArentPositiveNumbers)
{
    for (const double target : {0.0, -1.0})
    {
        PosedObject object = objectOf(1, 0, {{0, 0, 0}});
        object.target = target;
        EXPECT_EQ(select({object}).report.noTarget, 1);
    }
    for (const double target : {std::nan(""), std::numeric_limits<double>::infinity()})
    {
        PosedObject object = objectOf(1, 0, {{0, 0, 0}});
        object.target = target;
        EXPECT_EQ(select({object}).report.notFinite, 1);
    }
}

TEST_F(ControlPointSelector, PointsNearerThanAWavelengthToAReflectorAreLeftOut)
{
    Reflector plate;
    plate.position = {0.0, -0.01, 0.0};
    plate.normal = Eigen::Vector3d::UnitY();
    plate.along = Eigen::Vector3d::UnitX();
    plate.size_m = {0.04, 0.04};
    array.reflectors = {plate};
    const Selection selection = select({objectOf(0,
                                                 0,
                                                 {{0.0, -0.02, 0.0},
                                                  {0.0, -0.01 + 1.01 * kWavelength, 0.0},
                                                  {0.02, -0.01 + 0.99 * kWavelength, 0.0},
                                                  {0.04, -0.01, 0.0}})});
    EXPECT_EQ(selection.report.selected, 3);
    EXPECT_EQ(selection.report.atReflector, 1);
    EXPECT_NE(selection.report.summary().find("1 nearer than a wavelength to a reflector"),
              std::string::npos)
        << selection.report.summary();
    array.reflectors[0].reflection = 0.0;
    EXPECT_EQ(select({objectOf(0, 0, {{0.0, -0.01, 0.0}})}).report.selected, 1);
}

TEST_F(ControlPointSelector, JudgesTheWorkspaceOfAPrismAndABoard)
{
    using Verdict = Workspace::Verdict;
    const Workspace prism(array, kWavelength, options);
    // The apothem is 231.8 mm; all round the prism, inside and outside of it.
    for (int i = 0; i < 360; i += 5)
    {
        const Eigen::Vector3d out(std::cos(i * M_PI / 180.0), 0.0, std::sin(i * M_PI / 180.0));
        EXPECT_EQ(prism.judge(0.22 * out), Verdict::INSIDE) << i;
        EXPECT_EQ(prism.judge(0.26 * out), Verdict::BEHIND) << i;
        EXPECT_EQ(prism.judge(0.6 * out), Verdict::BEHIND) << i;
    }
    EXPECT_EQ(prism.judge({0.0, 0.3, 0.0}), Verdict::INSIDE); // beyond the open end
    EXPECT_EQ(prism.judge({0.0, 3.0, 0.0}), Verdict::OUT_OF_REACH);

    const Workspace board(TransducerArray::singleBoard(), kWavelength, options);
    EXPECT_EQ(board.judge({0.0, 0.0, 0.2}), Verdict::INSIDE);
    EXPECT_EQ(board.judge({0.2, 0.0, 0.05}), Verdict::INSIDE);
    EXPECT_EQ(board.judge({0.0, 0.0, -0.01}), Verdict::BEHIND);
    EXPECT_EQ(board.judge({0.2, 0.0, -0.01}), Verdict::BEHIND);
    EXPECT_EQ(board.judge({0.005, 0.005, 0.004}), Verdict::TOO_CLOSE);
    EXPECT_EQ(board.judge({0.0, 0.0, 1.0}), Verdict::OUT_OF_REACH);
    EXPECT_DOUBLE_EQ(board.minDistance_m(), kWavelength);

    // One transducer more at the side, a little above the board and facing it: points before the
    // board, but just behind that one and aside of it, are still seen by the board.
    TransducerArray pair = TransducerArray::singleBoard();
    const int last = pair.size();
    pair.positions.conservativeResize(3, last + 1);
    pair.normals.conservativeResize(3, last + 1);
    pair.positions.col(last) = Eigen::Vector3d(0.3, 0.0, 0.2);
    pair.normals.col(last) = -Eigen::Vector3d::UnitZ();
    EXPECT_EQ(Workspace(pair, kWavelength, options).judge({0.2, 0.0, 0.21}), Verdict::INSIDE);
    EXPECT_EQ(Workspace(pair, kWavelength, options).judge({0.3, 0.0, 0.21}), Verdict::BEHIND);
}

TEST_F(ControlPointSelector, KeepsTheSpacingAcrossObjectsByPriority)
{
    const PosedObject low = ball(1, 0, 0.03, {-0.01, 0.0, 0.0});
    const PosedObject high = ball(2, 5, 0.03, {0.01, 0.0, 0.0});
    const Selection selection = select({low, high});
    EXPECT_EQ(selection.report.perObject[1], high.positions.cols());
    EXPECT_GT(selection.report.spacedOut + selection.report.crowdThinned, 5);
    EXPECT_GE(test::smallestDistance(selection.points.positions), kWavelength * (1.0 - 1e-6));
    // Nothing was left out that had room.
    for (const auto& point : low.positions.colwise())
    {
        EXPECT_LT((selection.points.positions.colwise() - point).colwise().norm().minCoeff(),
                  kWavelength);
    }
}

TEST_F(ControlPointSelector, ThePointNearerTheMiddleStaysAmongEquals)
{
    const Selection selection =
        select({objectOf(1, 0, {{0.020, 0, 0}}), objectOf(2, 0, {{0.015, 0, 0}})});
    ASSERT_EQ(selection.points.size(), 1);
    EXPECT_EQ(selection.points.object[0], 2);
    EXPECT_EQ(selection.report.spacedOut, 1);
}

TEST_F(ControlPointSelector, TheLargerSpacingCountsBetweenObjects)
{
    PosedObject dense = objectOf(1, 1, {{0, 0, 0}, {0.003, 0, 0}, {0.006, 0, 0}});
    dense.spacing_m = 0.002;
    const PosedObject wide = objectOf(2, 0, {{0.0125, 0, 0}, {0.016, 0, 0}});
    const Selection selection = select({dense, wide});
    // 12.5 mm is 6.5 mm from the last dense point; 16 mm is 10 mm from it and crowds nothing.
    EXPECT_EQ(selection.report.perObject, (std::vector<int>{3, 1}));
    EXPECT_EQ(selection.points.positions(0, 3), 0.016);
}

TEST_F(ControlPointSelector, ADenseOutlineIsNoCrowdOfItsOwn)
{
    PosedObject outline = objectOf(1, 0, {{0, 0, 0}, {0.0022, 0, 0}, {0.0044, 0, 0}});
    outline.spacing_m = 0.0022; // a quarter of a wavelength, as asked for
    EXPECT_EQ(select({outline}).points.size(), 3);
    outline.spacing_m = kWavelength; // squeezed by deformation
    EXPECT_EQ(select({outline}).points.size(), 2);
}

TEST_F(ControlPointSelector, ResolvesCrowdsAsAsked)
{
    PosedObject object = objectOf(1, 0, {{0, 0, 0}, {0.002, 0, 0}, {0.05, 0, 0}});
    object.intensity.resize(3);
    object.intensity << 0.5F, 1.0F, 0.25F;

    options.crowding = Crowding::THIN;
    Selection selection = select({object});
    EXPECT_EQ(selection.sample, (std::vector<int>{0, 2}));
    EXPECT_EQ(selection.report.crowdThinned, 1);

    options.crowding = Crowding::MERGE;
    selection = select({object});
    EXPECT_EQ(selection.sample, (std::vector<int>{0, 2}));
    EXPECT_EQ(selection.report.crowdMerged, 1);
    EXPECT_DOUBLE_EQ(selection.points.positions(0, 0), 0.001);
    EXPECT_EQ(selection.points.targets[0], 1.0);
    EXPECT_EQ(selection.points.targets[1], 0.25);

    options.crowding = Crowding::DROP;
    selection = select({object});
    EXPECT_EQ(selection.sample, (std::vector<int>{2}));
    EXPECT_EQ(selection.report.crowdDropped, 2);
    EXPECT_EQ(selection.report.summary(), "1 of 3 points: 2 dropped from crowds");
}

TEST_F(ControlPointSelector, CrowdsEndUpApart)
{
    // 300 random points in a 20 mm cube: after any policy none is nearer than a third of a
    // wavelength.
    std::mt19937 random(3);
    std::uniform_real_distribution<double> coordinate(-0.01, 0.01);
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < 300; ++i)
        points.emplace_back(coordinate(random), coordinate(random), coordinate(random));
    points.push_back(points.front()); // and one twice
    for (const Crowding crowding : {Crowding::THIN, Crowding::MERGE, Crowding::DROP})
    {
        options.crowding = crowding;
        const Selection selection = select({objectOf(1, 0, points)});
        EXPECT_GT(selection.points.size(), crowding == Crowding::DROP ? 0 : 20);
        EXPECT_GE(test::smallestDistance(selection.points.positions),
                  kWavelength / 3.0 * (1.0 - 1e-6));
    }
}

TEST_F(ControlPointSelector, SharesTheBudgetByPriority)
{
    const PosedObject first = ball(1, 1, 0.03, {0.0, 0.0, 0.0});
    const PosedObject second = ball(2, 0, 0.03, {0.1, 0.0, 0.0});
    const PosedObject third = ball(3, 0, 0.02, {-0.1, 0.0, 0.0});
    const int n1 = static_cast<int>(first.positions.cols());
    const int n2 = static_cast<int>(second.positions.cols());
    const int n3 = static_cast<int>(third.positions.cols());
    options.maxPoints = n1 + (n2 + n3) / 2;
    const Selection selection = select({second, first, third});
    EXPECT_EQ(selection.points.size(), options.maxPoints);
    EXPECT_EQ(selection.report.perObject[1], n1);
    // In proportion, to the point.
    EXPECT_NEAR(selection.report.perObject[0], 0.5 * n2, 1.0);
    EXPECT_NEAR(selection.report.perObject[2], 0.5 * n3, 1.0);
    EXPECT_EQ(selection.report.overBudget, n1 + n2 + n3 - options.maxPoints);
    // Spread over the whole object: no spot is farther than two spacings from a point.
    EXPECT_LE(test::largestGap(
                  test::sphere(0.03, 2),
                  (selection.points.positions.colwise() - Eigen::Vector3d(0.1, 0.0, 0.0)).eval(),
                  5e-3),
              2.0 * kWavelength);

    options.maxPoints = n1 / 2; // the lower ones get nothing, and it is told
    const Selection few = select({second, first, third});
    EXPECT_EQ(few.report.perObject, (std::vector<int>{0, n1 / 2, 0}));
    options.maxPoints = 1;
    EXPECT_EQ(select({second, first, third}).points.size(), 1);
}

TEST_F(ControlPointSelector, TheOrderOfObjectsAndPointsDoesntMatter)
{
    std::vector<PosedObject> objects = {ball(1, 0, 0.03, {-0.01, 0.0, 0.0}),
                                        ball(2, 0, 0.03, {0.013, 0.0, 0.004}),
                                        ball(3, 1, 0.02, {0.0, 0.02, 0.0})};
    const auto sorted = [](const Selection& selection)
    {
        std::vector<std::vector<double>> points;
        for (int i = 0; i < selection.points.size(); ++i)
        {
            const Eigen::Vector3d p = selection.points.positions.col(i);
            points.push_back(
                {p.x(),
                 p.y(),
                 p.z(),
                 selection.points.targets[i],
                 static_cast<double>(selection.points.object[static_cast<std::size_t>(i)])});
        }
        std::sort(points.begin(), points.end());
        return points;
    };
    for (const Crowding crowding : {Crowding::THIN, Crowding::MERGE, Crowding::DROP})
    {
        options.crowding = crowding;
        const auto before = sorted(select(objects));
        EXPECT_GT(before.size(), 50U);
        std::vector<PosedObject> turned = {objects[2], objects[0], objects[1]};
        for (PosedObject& object : turned)
        {
            object.positions.rowwise().reverseInPlace();
            object.normals.rowwise().reverseInPlace();
        }
        EXPECT_EQ(sorted(select(turned)), before);
    }
}

TEST_F(ControlPointSelector, TakesThousandsOfPoints)
{
    std::vector<PosedObject> objects;
    for (int i = 0; i < 8; ++i)
    {
        objects.push_back(ball(i,
                               i % 3,
                               0.03,
                               {0.12 * std::cos(i * M_PI / 4), 0.0, 0.12 * std::sin(i * M_PI / 4)},
                               3e-3));
    }
    options.maxPoints = 20000;
    const Selection selection = select(objects);
    EXPECT_GT(selection.report.candidates, 6000);
    EXPECT_EQ(selection.report.selected,
              selection.report.candidates); // the balls stay clear of each other
}

TEST_F(ControlPointSelector, RefusesWhatItCantUse)
{
    const auto errorOf =
        [&](const std::vector<PosedObject>& objects, double wavelength = kWavelength)
    {
        try
        {
            selectControlPoints(objects, Workspace(array, wavelength, options), options);
        }
        catch (const base::InputError& error)
        {
            return std::string(error.what());
        }
        return std::string("no error");
    };
    PosedObject object = objectOf(1, 0, {{0, 0, 0}, {0.05, 0, 0}});
    object.normals.resize(3, 1);
    EXPECT_EQ(errorOf({object}),
              "Object 0 has 2 positions, 1 normals, 0 intensities and 0 identities; they must be "
              "as many");
    object = objectOf(1, 0, {{0, 0, 0}});
    object.spacing_m = 0.0;
    EXPECT_EQ(errorOf({object}), "Object 0 has the spacing 0 m; it must be positive and finite");
    EXPECT_EQ(errorOf({}, 0.0), "The wavelength is 0 m; it must be positive and finite");
    options.maxPoints = 0;
    EXPECT_EQ(errorOf({}), "SelectorOptions::maxPoints is 0; it must be at least 1");
    options = {};
    options.crowdingWavelengths = 2.0;
    EXPECT_EQ(errorOf({}), "SelectorOptions::crowdingWavelengths is 2; it must be within 0 .. 1");
    options = {};
    options.minDistanceWavelengths = std::nan("");
    EXPECT_EQ(errorOf({}), "SelectorOptions::minDistanceWavelengths is nan; it must be at least 0");
    options = {};
    options.reach_m = -1.0;
    EXPECT_EQ(errorOf({}), "SelectorOptions::reach_m is -1; it must be at least 0");
    options = {};
    array = TransducerArray();
    EXPECT_EQ(errorOf({}), "The array has no transducers");
}

} // namespace midair::haptics

#include "tests/referee/Scene.h"

#include "tests/haptics/solvers/ScenePoints.h"

#include <cmath>

namespace midair::referee
{

using haptics::ControlPoints;
using haptics::spherePoints;
using haptics::TransducerArray;

namespace
{

Scene sphere(const std::string& name, int n, double radius_m)
{
    Scene scene;
    scene.name = name;
    scene.array = TransducerArray::octagonalPrism();
    scene.points = spherePoints(n, radius_m);
    return scene;
}

Scene inPa(Scene scene, double target_Pa)
{
    scene.points.targets *= target_Pa;
    scene.points.absolute = true;
    return scene;
}

Scene piped(const std::string& name, double pressure_Pa, double cap_Pa)
{
    Scene scene;
    scene.name = name;
    scene.array = TransducerArray::octagonalPrism();
    scene.throughPipeline = true;
    scene.radius_m = 0.015;
    scene.pressure_Pa = pressure_Pa;
    scene.cap_Pa = cap_Pa;
    return scene;
}

/// Before one board, whose 249 transducers leave time for surfaces.
Scene beforeBoard(Scene scene)
{
    scene.array = TransducerArray::singleBoard();
    scene.centre = {0.0, 0.0, 0.12};
    scene.isMeasured = true;
    return scene;
}

std::vector<Scene> ofThePipeline()
{
    std::vector<Scene> scenes = {piped("pipeline", 0.0, 0.0),
                                 piped("pipeline at 500 Pa", 500.0, 0.0),
                                 piped("pipeline, capped", 0.0, 900.0),
                                 piped("pipeline, cycle of 4", 0.0, 0.0),
                                 piped("pipeline, 3 subsets", 0.0, 0.0),
                                 piped("pipeline, 3 subsets at 500 Pa", 500.0, 0.0),
                                 beforeBoard(piped("board, surface", 0.0, 0.0)),
                                 beforeBoard(piped("board, surface of a cycle of 3", 0.0, 0.0)),
                                 beforeBoard(piped("board, surface of 2 subsets", 0.0, 0.0))};
    scenes[2].threads = scenes[3].threads = 2;
    scenes[3].cycle = 4;
    scenes[4].subsets = scenes[5].subsets = 3;
    scenes[7].cycle = 3;
    scenes[8].subsets = 2;
    return scenes;
}

std::vector<Scene> ofEqualAndUnequalPoints()
{
    std::vector<Scene> scenes = {sphere("sphere 25, 30 mm", 25, 0.03),
                                 sphere("sphere 100, 30 mm", 100, 0.03),
                                 sphere("crowded 100, 15 mm", 100, 0.015),
                                 sphere("unequal 50, one left out", 50, 0.03)};
    // From 0.3 to 1 in no order, as midair-bench has them.
    for (int l = 0; l < 50; ++l)
        scenes.back().points.targets[l] = l == 7 ? 0.0 : 0.3 + 0.7 * (l * 7919 % 100) / 99.0;
    scenes.push_back(sphere("unequal 100, 1:1000", 100, 0.03));
    for (int l = 0; l < 100; ++l)
        scenes.back().points.targets[l] = std::pow(10.0, -3.0 * (l * 7919 % 100) / 99.0);
    scenes.push_back(sphere("loudness 1.5, 50", 50, 0.03));
    scenes.back().loudness = 1.5;
    return scenes;
}

} // namespace

std::vector<Scene> allScenes()
{
    std::vector<Scene> scenes = ofEqualAndUnequalPoints();
    scenes.push_back(inPa(sphere("50 at 400 Pa", 50, 0.03), 400.0));
    scenes.push_back(inPa(sphere("25 swinging in Pa", 25, 0.03), 600.0));
    scenes.back().swing = 0.3;
    scenes.push_back(inPa(sphere("25, some out of reach", 25, 0.03), 1.0));
    // One focus reaches 40 kPa (peak) at full drive; 25 points share that to about 8 kPa each.
    for (int l = 0; l < 25; ++l)
        scenes.back().points.targets[l] = 2000.0 + 500.0 * l;
    scenes.push_back(sphere("amplitudes, 25", 25, 0.03));
    scenes.back().phaseOnly = false;
    scenes.push_back(inPa(sphere("amplitudes, 50 at 400 Pa", 50, 0.03), 400.0));
    scenes.back().phaseOnly = false;
    scenes.push_back(sphere("coarse array, 9", 9, 0.02));
    scenes.back().array = TransducerArray::load("sonicsurface");
    scenes.back().points.positions.row(2).array() += 0.12;
    scenes.push_back(sphere("two threads, 50", 50, 0.03));
    scenes.back().threads = 2;
    for (Scene& scene : ofThePipeline())
        scenes.push_back(std::move(scene));
    return scenes;
}

void Motion::next()
{
    const int phase = _k % 20;
    const double step_m = phase < 8 ? 1e-3 : phase < 11 ? 1e-4 : 5e-9;
    const double t = 0.05 * _k++;
    _pose.translation() += step_m * Eigen::Vector3d(std::cos(t) * std::cos(2 * t),
                                                    std::sin(t) * std::cos(2 * t),
                                                    -std::sin(2 * t));
    if (phase >= 8) return;
    const Eigen::Vector3d axis = Eigen::Vector3d(std::cos(3 * t), std::sin(t), 1.0).normalized();
    _pose.linear() = Eigen::AngleAxisd(M_PI / 180.0, axis) * _pose.linear();
}

double swingAt(const Scene& scene, int k)
{
    return 1.0 + scene.swing * std::sin(2.0 * M_PI * k / 40.0);
}

ControlPoints pointsAt(const Scene& scene, const Eigen::Isometry3d& pose, int k)
{
    ControlPoints points = scene.points;
    const Eigen::Vector3d centre = scene.points.positions.rowwise().mean();
    points.positions =
        ((pose.linear() * (points.positions.colwise() - centre)).colwise() + pose.translation())
            .colwise() +
        centre;
    points.normals = pose.linear() * points.normals;
    points.targets *= swingAt(scene, k);
    return points;
}

} // namespace midair::referee

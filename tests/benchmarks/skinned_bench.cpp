// midair-skinned-bench: a figure of body and two arms, held and carried against skinned: shoulders
// swing, elbows bend until the hands touch the body, and what touches or is stretched changes the
// set of points. Times of updates on one core, and how exact they are.

#include "tests/benchmarks/Updates.h"
#include "tests/engine-bridge/pipeline/Fakes.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include <CLI/CLI.hpp>

using midair::haptics::TriangleMesh;

namespace
{

constexpr double kSpeed_m_s = 0.2, kFrames_Hz = 60.0;

/// A capsule-shaped limb, skinned by the bones that its parts hang on.
struct Limb
{
    double length_m;
    double radius_m;
};
constexpr Limb kBody{0.155, 0.052}, kArm{0.144, 0.0155};

/// Vertices of \a limb along +x from the origin, rows from end to end; appends its triangles.
Eigen::Matrix3Xd limbAlongX(const Limb& limb, std::vector<Eigen::Vector3i>& triangles, int first)
{
    constexpr int kRows = 40, kColumns = 24;
    Eigen::Matrix3Xd vertices(3, kRows * kColumns);
    for (int r = 0; r < kRows; ++r)
        for (int c = 0; c < kColumns; ++c)
        {
            const double along = static_cast<double>(r) / (kRows - 1);
            const double round = 2.0 * M_PI * c / kColumns;
            // Rounded at both ends.
            const double end_m = std::min(along, 1.0 - along) * limb.length_m;
            const double in = std::max(0.0, 1.0 - end_m / limb.radius_m);
            const double radius_m = limb.radius_m * std::sqrt(std::max(1.0 - in * in, 1e-4));
            vertices.col(r * kColumns + c) = Eigen::Vector3d(
                along * limb.length_m, radius_m * std::cos(round), radius_m * std::sin(round));
            if (r + 1 == kRows) continue;
            const int a = first + r * kColumns + c, b = first + r * kColumns + (c + 1) % kColumns;
            triangles.emplace_back(a, a + kColumns, b);
            triangles.emplace_back(b, a + kColumns, b + kColumns);
        }
    return vertices;
}

/// Linear blend skinning of an arm along +x: the forearm is bent by \a elbow_rad round z.
Eigen::Matrix3Xd bent(const Eigen::Matrix3Xd& arm, double elbow_rad)
{
    const double middle_m = 0.5 * kArm.length_m, blend_m = 0.03;
    const Eigen::Vector3d joint(middle_m, 0.0, 0.0);
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(elbow_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    Eigen::Matrix3Xd out = arm;
    for (auto vertex : out.colwise())
    {
        const double weight = std::clamp((vertex.x() - middle_m) / blend_m + 0.5, 0.0, 1.0);
        vertex = ((1.0 - weight) * vertex + weight * (joint + turn * (vertex - joint))).eval();
    }
    return out;
}

/// The figure at rest, and where its bones put its vertices.
class Figure
{
public:
    Figure()
    {
        std::vector<Eigen::Vector3i> triangles;
        _body = limbAlongX(kBody, triangles, 0);
        const int body = static_cast<int>(_body.cols());
        _arm = limbAlongX(kArm, triangles, body);
        limbAlongX(kArm, triangles, body + static_cast<int>(_arm.cols()));
        _triangles.resize(3, static_cast<Eigen::Index>(triangles.size()));
        for (std::size_t i = 0; i < triangles.size(); ++i)
            _triangles.col(static_cast<Eigen::Index>(i)) = triangles[i];
    }

    /// \a shoulder_rad: of both arms away from the body, which stands along x.
    std::shared_ptr<const TriangleMesh> posed(double shoulder_rad, double elbow_rad) const
    {
        const auto mesh = std::make_shared<TriangleMesh>();
        mesh->triangles = _triangles;
        mesh->vertices.resize(3, _body.cols() + 2 * _arm.cols());
        mesh->vertices.leftCols(_body.cols()) =
            _body.colwise() - Eigen::Vector3d(0.5 * kBody.length_m, 0.0, 0.0);
        for (const int side : {0, 1})
        {
            const double sign = side == 0 ? 1.0 : -1.0;
            const Eigen::Matrix3d swing =
                Eigen::AngleAxisd(sign * shoulder_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
            const Eigen::Vector3d shoulder(
                -0.3 * kBody.length_m, sign * (kBody.radius_m + 1.5 * kArm.radius_m), 0.0);
            mesh->vertices.middleCols(_body.cols() + side * _arm.cols(), _arm.cols()) =
                (swing * bent(_arm, -sign * elbow_rad)).colwise() + shoulder;
        }
        return mesh;
    }

private:
    Eigen::Matrix3Xd _body, _arm;
    Eigen::Matrix3Xi _triangles;
};

/// Runs \a updates of the figure, skinned or held and carried; prints what they took. Returns the
/// median, ms.
double run(const char* name, bool isSkinned, int updates)
{
    const Figure figure;
    midair::bridge::SceneSnapshot snapshot;
    snapshot.objects.resize(1);
    midair::bridge::HapticObject& object = snapshot.objects[0];
    object.id = object.meshId = object.topologyId = 1;
    object.path = name;
    constexpr double kShoulder_rad = 0.5, kElbow_rad = 0.9;
    object.mesh = figure.posed(kShoulder_rad, kElbow_rad);
    return midair::bench::timeUpdates(
        name,
        updates,
        snapshot,
        [&](int i)
        {
            const double way_m = i * kSpeed_m_s / kFrames_Hz;
            if (isSkinned)
            {
                // Hands travel about as fast as the carried figure.
                const double phase = way_m / 0.05;
                object.mesh = figure.posed(kShoulder_rad + 0.35 * std::sin(phase),
                                           kElbow_rad + 0.5 * std::sin(0.7 * phase));
                object.meshId = static_cast<std::uint64_t>(i) + 1;
            }
            else
                object.pose.translation() =
                    0.02 * Eigen::Vector3d(std::cos(way_m / 0.02), 0.0, std::sin(way_m / 0.02));
        });
}

} // namespace

int main(int argc, char** argv)
{
    int updates = 600;
    CLI::App app(
        "Compares update times of a skinned figure with those of a rigidly moved one, on one core");
    app.add_option("--updates", updates, "updates per line")->check(CLI::Range(10, 100000));
    CLI11_PARSE(app, argc, argv);
    const double carried_ms = run("carried", false, updates);
    const double skinned_ms = run("skinned", true, updates);
    std::printf("skinned takes %.2f times as long as carried\n", skinned_ms / carried_ms);
    return 0;
}

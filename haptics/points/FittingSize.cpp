#include "haptics/points/FittingSize.h"

#include "haptics/base/InputError.h"

#include <algorithm>
#include <cmath>

namespace midair::haptics
{

namespace
{

/// Number of tried places in front of the middle of an array, up to its reach.
constexpr int kPlaces = 40;
constexpr double kLeast_m = 1e-3;

double areaOf(const TriangleMesh& mesh)
{
    double twice_m2 = 0.0;
    for (Eigen::Index i = 0; i < mesh.triangles.cols(); ++i)
    {
        const Eigen::Vector3i corners = mesh.triangles.col(i);
        if (corners.minCoeff() < 0 || corners.maxCoeff() >= mesh.vertices.cols()) continue;
        const Eigen::Vector3d a = mesh.vertices.col(corners[0]);
        const Eigen::Vector3d ab = mesh.vertices.col(corners[1]) - a;
        twice_m2 += ab.cross(mesh.vertices.col(corners[2]) - a).norm();
    }
    return 0.5 * twice_m2;
}

bool isInside(const Eigen::Vector3d& middle, const Eigen::Vector3d& extent, const Workspace& space)
{
    for (int corner = 0; corner < 8; ++corner)
    {
        const Eigen::Vector3d side((corner & 1) != 0 ? 0.5 : -0.5,
                                   (corner & 2) != 0 ? 0.5 : -0.5,
                                   (corner & 4) != 0 ? 0.5 : -0.5);
        const Eigen::Vector3d place = middle + side.cwiseProduct(extent);
        if (space.judge(place) != Workspace::Verdict::INSIDE) return false;
    }
    return true;
}

} // namespace

ArrayFront::ArrayFront(const Eigen::Matrix3Xd& positions, const Eigen::Matrix3Xd& normals) :
    middle(positions.rowwise().mean()),
    ahead(normals.rowwise().mean())
{
    constexpr double kLeast = 0.01; // of the mean of unit vectors: below it there is no common
                                    // direction
    const double length = ahead.norm();
    ahead = length > kLeast ? Eigen::Vector3d(ahead / length) : Eigen::Vector3d::Zero();
}

bool hasRoom(const Eigen::Vector3d& extent_m, const Workspace& workspace, const ArrayFront& front)
{
    const int places = front.ahead.isZero() ? 0 : kPlaces;
    for (int i = 0; i <= places; ++i)
    {
        const double way_m = workspace.reach_m() * i / kPlaces;
        if (isInside(front.middle + front.ahead * way_m, extent_m, workspace)) return true;
    }
    return false;
}

double roomInside_m(const Workspace& workspace, const ArrayFront& front)
{
    double fits = 0.0;
    double tooLarge = 2.0 * workspace.reach_m();
    while (tooLarge - fits > 0.01 * workspace.reach_m())
    {
        const double size = 0.5 * (fits + tooLarge);
        (hasRoom(Eigen::Vector3d::Constant(size), workspace, front) ? fits : tooLarge) = size;
    }
    return fits;
}

double fittingSize_m(const LargeModel& model,
                     const Workspace& workspace,
                     const ArrayFront& front,
                     int maxPoints)
{
    const Eigen::Matrix3Xd placed = model.pose * model.mesh.vertices;
    const Eigen::Vector3d extent = placed.rowwise().maxCoeff() - placed.rowwise().minCoeff();
    // About one point per square of the spacing.
    const double spacing2 = model.spacing_m * model.spacing_m;
    const double points = spacing2 > 0.0 ? areaOf(model.mesh) / spacing2 : 0.0;
    const double most_m = model.mayGrow ? 2.0 * workspace.reach_m() : model.width_m;
    if (!(model.width_m > 0.0)) return 0.0;
    for (int power = static_cast<int>(std::floor(std::log10(most_m))); power >= -3; --power)
        for (const double digit : {5.0, 2.0, 1.0})
        {
            const double size = digit * std::pow(10.0, power);
            const double scale = size / model.width_m;
            if (size > most_m || size < kLeast_m) continue;
            if (points * scale * scale > maxPoints) continue;
            if (hasRoom(extent * scale, workspace, front)) return size;
        }
    return 0.0;
}

double proposedSize_m(double fitting_m)
{
    return std::min(fitting_m, kFeltBest_m);
}

bool isOneFocus(const TriangleMesh& mesh, double wavelength_m)
{
    const auto isPoint = [](const auto& corners)
    { return corners[0] == corners[1] && corners[1] == corners[2]; };
    if (mesh.vertices.cols() == 0 || !(mesh.extent().maxCoeff() < 0.5 * wavelength_m)) return false;
    for (Eigen::Index i = 0; i < mesh.triangles.cols(); ++i)
        if (!isPoint(mesh.triangles.col(i))) return true;
    return false;
}

int pointsAtSize(const TriangleMesh& mesh,
                 const SamplerOptions& sampling,
                 double size_m,
                 int maxPoints)
{
    if (!(size_m > 0.0)) return maxPoints;
    try
    {
        return std::clamp(sampleSurface(mesh.scaledTo(size_m), sampling).size(), 1, maxPoints);
    }
    catch (const base::InputError&) // too many
    {
        return maxPoints;
    }
}

} // namespace midair::haptics

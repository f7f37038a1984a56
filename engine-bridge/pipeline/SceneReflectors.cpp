#include "engine-bridge/pipeline/SceneReflectors.h"

#include "haptics/sequence/ReflectorFigures.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

using haptics::FlatFace;
using haptics::Reflector;

/// Share of the transducers that may be on the other side of a body's face.
constexpr double kFew = 0.1;

/// Returns the share of the transducers in front of \a rectangle.
double shareInFront(const Reflector& rectangle, const haptics::TransducerArray& array)
{
    int inFront = 0;
    for (int i = 0; i < array.size(); ++i)
        inFront += rectangle.heightOf(array.positions.col(i)) > 0.0 ? 1 : 0;
    return static_cast<double>(inFront) / std::max(1, array.size());
}

} // namespace

SceneReflectors reflectorsBeside(const haptics::TransducerArray& array,
                                 const std::vector<FlatFace>& faces)
{
    SceneReflectors beside;
    beside.all = array.reflectors;
    for (const FlatFace& face : faces)
    {
        const Reflector& one = face.rectangle;
        const double inFront = face.isOfBody ? shareInFront(one, array) : 1.0;
        if (inFront < kFew) continue; // it hides behind its body
        std::string problem;
        if (inFront <= 1.0 - kFew)
            problem = fmt::format("{} is left out, as transducers are on both sides of a face of "
                                  "its body; make it a sheet",
                                  one.called(beside.all.size()));
        else if (haptics::areValid({one}, &problem) && !haptics::isRoomIn(beside.all))
            problem = fmt::format("{} is left out: there are more than {} reflectors, those of the "
                                  "array included",
                                  one.called(beside.all.size()),
                                  haptics::kMostReflectors);
        else if (!problem.empty())
            problem += "; it is left out";
        if (problem.empty())
            beside.all.push_back(one);
        else if (std::count(beside.problems.begin(), beside.problems.end(), problem) == 0)
            beside.problems.push_back(problem);
    }
    for (std::size_t k = 0; k < beside.all.size(); ++k)
    {
        const Reflector& one = beside.all[k];
        if (one.accuracy_mm <= haptics::kMostCorrectedAccuracy_mm || one.reflection == 0.0)
            beside.corrected.push_back(one);
        else
            beside.problems.push_back(
                fmt::format("fields aren't corrected for {}: its accuracy is {:g} mm, and a "
                            "correction needs {:g} mm or better; figures and caps know it",
                            one.called(k),
                            one.accuracy_mm,
                            haptics::kMostCorrectedAccuracy_mm));
    }
    return beside;
}

bool areUnmoved(const std::vector<FlatFace>& a, const std::vector<FlatFace>& b, double tolerance_m)
{
    const auto isUnmoved = [&](const FlatFace& one, const FlatFace& other)
    {
        FlatFace there = one;
        there.rectangle.position = other.rectangle.position;
        there.rectangle.normal = other.rectangle.normal;
        there.rectangle.along = other.rectangle.along;
        if (!(there == other)) return false;
        const Eigen::Vector2d half = 0.5 * one.rectangle.size_m;
        for (const double x : {-half.x(), half.x()})
            for (const double y : {-half.y(), half.y()})
            {
                const auto corner = [&](const Reflector& of) -> Eigen::Vector3d
                { return of.position + x * of.along + y * of.across(); };
                const double moved_m = (corner(one.rectangle) - corner(other.rectangle)).norm();
                if (!(moved_m <= tolerance_m)) return false;
            }
        return true;
    };
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), isUnmoved);
}

bool areUnmoved(const std::vector<haptics::ReflectingBody>& a,
                const std::vector<haptics::ReflectingBody>& b,
                double tolerance_m)
{
    const auto isUnmoved =
        [&](const haptics::ReflectingBody& one, const haptics::ReflectingBody& other)
    {
        if (one.mesh != other.mesh) return false;
        const Eigen::Vector3d low = one.mesh->vertices.rowwise().minCoeff(),
                              high = one.mesh->vertices.rowwise().maxCoeff();
        for (int corner = 0; corner < 8; ++corner)
        {
            const Eigen::Vector3d at(corner & 1 ? high.x() : low.x(),
                                     corner & 2 ? high.y() : low.y(),
                                     corner & 4 ? high.z() : low.z());
            if (!((one.pose * at - other.pose * at).norm() <= tolerance_m)) return false;
        }
        return true;
    };
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), isUnmoved);
}

std::vector<std::string> reflectorsNear(const std::vector<Reflector>& reflectors,
                                        const Eigen::Matrix3Xd& skipped,
                                        double wavelength_m)
{
    std::vector<std::string> told;
    for (std::size_t k = 0; k < reflectors.size(); ++k)
    {
        const Reflector& one = reflectors[k];
        for (Eigen::Index l = 0; l < skipped.cols() && one.reflection > 0.0; ++l)
        {
            if (!(one.distanceTo(skipped.col(l)) < wavelength_m)) continue;
            told.push_back("points nearer than a wavelength to " + one.called(k) +
                           " are left out, as its images are no waves there");
            break;
        }
    }
    return told;
}

} // namespace midair::bridge

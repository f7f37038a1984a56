#include "engine-bridge/pipeline/PointAssembler.h"

#include "engine-bridge/calibration/PointPairs.h"
#include "haptics/base/Limits.h"
#include "haptics/points/FittingSize.h"
#include "haptics/sequence/FocusShare.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

/// Least distance of given points from those of other objects; nearer ones count as the same.
constexpr double kGivenSpacing_m = 1e-6;

/// Largest relative change of the wavelength, as by 6 K of air, for which objects without their own
/// spacing keep it: other samples would need a field from scratch.
constexpr double kSameSpacing = 0.01;

/// Largest distance that any of \a corners moves from pose \a a to pose \a b.
double travel(const Eigen::Matrix<double, 3, 8>& corners,
              const Eigen::Isometry3d& a,
              const Eigen::Isometry3d& b)
{
    const Eigen::Matrix3d turned = b.linear() - a.linear();
    const Eigen::Vector3d moved = b.translation() - a.translation();
    return ((turned * corners).colwise() + moved).colwise().norm().maxCoeff();
}

// The identity of the first sample of an object, a number far from those of others (the finalizer
// of splitmix64: Steele, Lea, Flood 2014, "Fast splittable pseudorandom number generators").
std::uint64_t firstIdentity(std::uint64_t object, std::uint64_t sampling)
{
    std::uint64_t mixed = object * 0x9e3779b97f4a7c15ull + sampling;
    mixed = (mixed ^ (mixed >> 30)) * 0xbf58476d1ce4e5b9ull;
    mixed = (mixed ^ (mixed >> 27)) * 0x94d049bb133111ebull;
    return mixed ^ (mixed >> 31);
}

haptics::SelectorOptions selectorOptions(const PointAssembler::Options& options)
{
    haptics::SelectorOptions selector;
    if (options.maxPoints > 0) selector.maxPoints = options.maxPoints;
    return selector;
}

std::uint64_t outOfWorkspace(const haptics::SelectionReport& report)
{
    return static_cast<std::uint64_t>(report.tooClose + report.behind + report.atReflector +
                                      report.outOfReach);
}

/// Objects this many times as wide as the array probably use other units.
constexpr double kWide = 10.0;
/// Objects below this share of the array's width are never too large.
constexpr double kNarrow = 0.25;

Eigen::Vector3d widths(const Eigen::Matrix3Xd& places)
{
    return places.rowwise().maxCoeff() - places.rowwise().minCoeff();
}

/// \a fitting_m: the largest size that fits; 0: none.
std::string proposal(double fitting_m)
{
    return fitting_m > 0.0 ? fmt::format("size={:.3g} fits", haptics::proposedSize_m(fitting_m))
                           : "";
}

/// End of a message about a model \a width_m wide at \a metresPerUnit; \a fitting_m is the largest
/// size that fits (0: none). Names the unit in which it was probably made, after \a before, and a
/// size if it doesn't fit in that unit. The unit is the longest of metres, centimetres and
/// millimetres with which the model is at most \a most_m wide, else the shortest with which it is
/// at least \a least_m wide; none if none is better than the present one.
std::string unitAndSize(const char* before,
                        double width_m,
                        double metresPerUnit,
                        double least_m,
                        double most_m,
                        double fitting_m)
{
    const auto widthIn = [&](double unit_m) { return width_m / metresPerUnit * unit_m; };
    double unit_m = 0.0;
    for (const double one_m : {1e-3, 1e-2, 1.0})
        if (widthIn(one_m) >= least_m && (unit_m == 0.0 || widthIn(one_m) <= most_m))
            unit_m = one_m;
    if (unit_m == 0.0 || (unit_m < metresPerUnit) != (width_m > most_m))
        return fitting_m > 0.0 ? "; " + proposal(fitting_m) : "";
    const bool fits = widthIn(unit_m) <= fitting_m; // and so do its neighbours in that file
    return fmt::format("{}should metresPerUnit be {:g} ({}), not {:g}?{}{}",
                       before,
                       unit_m,
                       unitName(unit_m),
                       metresPerUnit,
                       fits || !(fitting_m > 0.0) ? "" : " ",
                       fits ? "" : proposal(fitting_m));
}

} // namespace

PointAssembler::PointAssembler(const haptics::TransducerArray& array,
                               const Options& options,
                               base::MessageLog& messages) :
    _options(options),
    _spacing_m(options.wavelength_m),
    _selector(selectorOptions(options)),
    _workspace(array, options.wavelength_m, _selector),
    _array(array),
    _messages(messages)
{
}

void PointAssembler::setOptions(const haptics::TransducerArray& array, const Options& options)
{
    _assembled = false;
    if (options == _options && array.reflectors == _array.reflectors) return;
    const base::StopToken stop = _selector.stop;
    _options = options;
    if (!(std::fabs(options.wavelength_m / _spacing_m - 1.0) <= kSameSpacing))
        _spacing_m = options.wavelength_m;
    _selector = selectorOptions(options);
    _selector.stop = stop;
    _workspace = haptics::Workspace(array, options.wavelength_m, _selector);
    _array = array;
}

void PointAssembler::setStop(const base::StopToken& stop)
{
    _selector.stop = stop;
    _samples.setStop(stop);
}

bool PointAssembler::unmoved(const SceneSnapshot& snapshot)
{
    if (!_assembled || snapshot.objects.size() != _placed.size()) return false;
    for (std::size_t i = 0; i < _placed.size(); ++i)
    {
        const HapticObject& now = snapshot.objects[i];
        const Placed& then = _placed[i];
        // A pose that is not finite counts as moved.
        const bool still = now.id == then.id && now.meshId == then.meshId &&
                           now.properties == then.properties && now.clips == then.clips &&
                           now.share == then.share &&
                           travel(then.corners, now.pose, then.pose) <= _options.motionTolerance_m;
        if (!still) return false;
    }
    return true;
}

bool PointAssembler::withinReach(const HapticObject& object) const
{
    const Eigen::Matrix3Xd& vertices = object.mesh->vertices;
    const Eigen::Vector3d low = vertices.rowwise().minCoeff();
    const Eigen::Vector3d high = vertices.rowwise().maxCoeff();
    const double radius = 0.5 * (high - low).norm();
    if (!std::isfinite(radius)) return true; // the sampler reports the error
    const Eigen::Vector3d middle = object.pose * (0.5 * (low + high)).eval();
    const double nearest = (_array.positions.colwise() - middle).colwise().norm().minCoeff();
    return nearest - radius <= _workspace.reach_m();
}

AssembledPoints PointAssembler::assemble(const SceneSnapshot& snapshot, int set)
{
    AssembledPoints out;
    double strongest_Pa = 0.0;
    for (const HapticObject& object : snapshot.objects)
        if (object.properties.pressureInPa)
            strongest_Pa = std::max(strongest_Pa, object.properties.pressure);
    const bool absolute = strongest_Pa > 0.0;

    _assembled = false; // stays false if a stop interrupts this
    _placed.clear();
    _posed.clear();
    _candidates = 0;
    _messages.beginLook();
    _wholes.large.clear();
    _wholes.felt.clear();
    _oneFocus.before = std::exchange(_oneFocus.now, {});
    out.objects.resize(snapshot.objects.size());
    for (std::size_t i = 0; i < snapshot.objects.size(); ++i)
    {
        const HapticObject& object = snapshot.objects[i];
        const HapticProperties& p = object.properties;
        Placed& placed = _placed.emplace_back();
        placed.id = object.id;
        placed.meshId = object.meshId;
        placed.properties = p;
        placed.clips = object.clips;
        placed.share = object.share;
        placed.pose = object.pose;
        tellUnused(object);
        // Where touched, or as a sensation.
        if (!(object.share > 0.0) || p.sensation.isMeant) continue;
        if (!usable(object)) continue;
        tellIfLarge(object, snapshot.metresPerUnit);
        tellIfSmall(snapshot, object);
        if (!withinReach(object))
        {
            if (!isAround(object)) _wholes.large.erase(object.touchId()); // its place matters
            ++out.outOfWorkspace;
            out.objects[i].isUnreachable = true;
            placed.corners = boxCorners(object.mesh->vertices);
            continue;
        }
        // If some objects are in Pa, the others are relative to the strongest of those.
        const double unit_Pa = absolute && !p.pressureInPa ? strongest_Pa : 1.0;
        add(object, static_cast<int>(i), object.share * unit_Pa, set, placed);
    }
    _samples.endSnapshot();
    select(snapshot, out);
    out.points.absolute = absolute;
    holdSmall(snapshot, out.points);
    tellUnreachable(snapshot, out);
    _messages.endLook();
    _assembled = true;
    return out;
}

void PointAssembler::add(
    const HapticObject& object, int index, double unit_Pa, int set, Placed& placed)
{
    const HapticProperties& p = object.properties;
    const double spacing_m = p.spacing_m > 0.0 ? p.spacing_m : _spacing_m;
    const CachedSamples& cached = _samples.get(object, spacing_m, _options.sets);
    placed.corners = cached.corners;
    if (!cached.error.empty())
    {
        // Not a separate problem of objects that are too large.
        if (_wholes.large.count(object.touchId()) == 0)
            tellOnce(
                base::MessageCode::OBJECT_INVALID, object, cached.error + "; it can't be felt");
        return;
    }
    const haptics::SurfaceSamples& samples =
        cached.sets[static_cast<std::size_t>(set) % cached.sets.size()];
    _candidates += samples.size();
    if (_candidates > base::kMostCandidates)
    {
        if (_wholes.large.count(object.touchId()) == 0)
            tellOnce(base::MessageCode::POINTS_BUDGET,
                     object,
                     fmt::format("with its {} samples the scene's objects have more than {} "
                                 "together; it can't be felt",
                                 samples.size(),
                                 base::kMostCandidates));
        _candidates -= samples.size();
        return;
    }
    haptics::PosedObject& posed = _posed.emplace_back();
    posed.object = index;
    posed.priority = p.priority;
    posed.target = p.pressure * unit_Pa;
    // Given points keep their distances.
    const bool given = p.sampling == haptics::Sampling::POINTS && !(p.spacing_m > 0.0);
    posed.spacing_m = given ? kGivenSpacing_m : spacing_m;
    posed.pose(samples, object.pose, firstIdentity(object.id, cached.sampling));
    keepSide(object, posed);
    if (object.clips.empty()) return;
    posed.keepIf([&](Eigen::Index i) { return !isClipped(object.clips, posed.positions.col(i)); });
}

void PointAssembler::keepSide(const HapticObject& object, haptics::PosedObject& posed)
{
    const Side side = object.properties.side;
    if (side == Side::BOTH) return;
    constexpr double kTie = 0.01; // of the sound from both sides; below: neither prevails
    const double wanted = side == Side::FRONT ? 1.0 : -1.0;
    const Eigen::Index all = posed.positions.cols();
    int ties = 0;
    base::StopLook look(_selector.stop, 16);
    const auto faces = [&](Eigen::Index i)
    {
        look.turn();
        // Lines and points have no normal, so they have both sides.
        if (posed.normals.col(i).isZero(0.0)) return true;
        // Direction of the sound: the sum of the directions to the transducers that face the point,
        // weighted with 1/R^2 like power.
        const Eigen::Matrix3Xd way = _array.positions.colwise() - posed.positions.col(i);
        const Eigen::ArrayXd facing =
            -(way.array() * _array.normals.array()).colwise().sum().transpose();
        const Eigen::ArrayXd distance = way.colwise().norm().transpose();
        const Eigen::ArrayXd weight =
            (facing > 0.0).select(1.0 / distance.cube(), Eigen::ArrayXd::Zero(distance.size()));
        const Eigen::ArrayXd along = (way.transpose() * posed.normals.col(i)).array() * weight;
        if (std::abs(along.sum()) <= kTie * along.abs().sum()) ++ties;
        return wanted * along.sum() > 0.0;
    };
    posed.keepIf(faces);
    if (ties > 0)
        tellOnce(
            base::MessageCode::OBJECT_SIDE,
            object,
            fmt::format(
                "side={}: {} of its {} points get as much sound from the front as from the back, "
                "so it is random which of them are felt; turn or move it, or use side=both",
                side == Side::FRONT ? "front" : "back",
                ties,
                all));
}

void PointAssembler::select(const SceneSnapshot& snapshot, AssembledPoints& out)
{
    haptics::Selection selection = haptics::selectControlPoints(_posed, _workspace, _selector);
    const haptics::SelectionReport& report = selection.report;
    out.points = std::move(selection.points);
    out.outOfWorkspace += outOfWorkspace(report);
    out.overBudget = static_cast<std::uint64_t>(report.overBudget);
    out.crowded = static_cast<std::uint64_t>(report.spacedOut + report.crowdThinned +
                                             report.crowdMerged + report.crowdDropped);
    out.unpainted = static_cast<std::uint64_t>(report.noTarget);
    for (std::size_t i = 0; i < _posed.size(); ++i)
        out.objects[static_cast<std::size_t>(_posed[i].object)].leftOut = report.leftOut[i];
    tellLeftOut(snapshot, report);

    Eigen::Index candidates = 0;
    for (const auto& posed : _posed)
        candidates += posed.positions.cols();
    std::vector<std::vector<bool>> chosen(_posed.size());
    for (std::size_t i = 0; i < _posed.size(); ++i)
        chosen[i].resize(static_cast<std::size_t>(_posed[i].positions.cols()));
    for (std::size_t k = 0; k < selection.source.size(); ++k)
        chosen[static_cast<std::size_t>(selection.source[k])]
              [static_cast<std::size_t>(selection.sample[k])] = true;
    out.skipped.resize(3, candidates);
    Eigen::Index n = 0;
    for (std::size_t i = 0; i < _posed.size(); ++i)
        for (std::size_t k = 0; k < chosen[i].size(); ++k)
            if (!chosen[i][k])
                out.skipped.col(n++) = _posed[i].positions.col(static_cast<Eigen::Index>(k));
    out.skipped.conservativeResize(3, n);
}

// Messages of a PointAssembler about objects that aren't rendered as intended.

bool PointAssembler::usable(const HapticObject& object)
{
    auto refuse = [this, &object](const std::string& why)
    {
        tellOnce(base::MessageCode::OBJECT_INVALID, object, why + "; it can't be felt");
        return false;
    };
    const HapticProperties& p = object.properties;
    if (!object.mesh || object.mesh->triangles.cols() == 0) return refuse("has no triangles");
    if (!object.pose.matrix().allFinite()) return refuse("its pose is not finite");
    if (!(p.pressure > 0.0) || !std::isfinite(p.pressure))
        return refuse(fmt::format("pressure is {:g}, should be over 0", p.pressure));
    if (!(p.spacing_m >= 0.0) || !std::isfinite(p.spacing_m))
        return refuse(fmt::format("spacing is {:g} m, should be at least 0", p.spacing_m));
    return true;
}

// Reports properties that have no effect in the object's render mode.
void PointAssembler::tellUnused(const HapticObject& object)
{
    const HapticProperties& p = object.properties;
    if (p.sensation.isMeant) return;
    const Render render = p.render == Render::INHERIT ? _options.render : p.render;
    if (render == Render::OBJECT && !(p.material == HapticMaterial()))
        tellOnce(base::MessageCode::PROPERTY_INVALID,
                 object,
                 "its material, stiffness or contactForce has no effect, because it is played as a "
                 "whole; set render to contact or auto");
    if (render == Render::CONTACT && (p.pressureInPa || p.pressure != 1.0))
        tellOnce(base::MessageCode::PROPERTY_INVALID,
                 object,
                 "its pressure has no effect, because it is played only where hands touch it; "
                 "contactForce and stiffness set the strength");
}

void PointAssembler::tellOnce(base::MessageCode code,
                              const HapticObject& object,
                              const std::string& what)
{
    _messages.note({code, object.touchId(), base::withoutNumbers(what)},
                   base::about(code, object.path, what, object.origin));
}

haptics::SamplerOptions PointAssembler::samplerOptions(const HapticObject& object) const
{
    haptics::SamplerOptions options;
    const double spacing_m = object.properties.spacing_m;
    options.spacing_m = spacing_m > 0.0 ? spacing_m : _options.wavelength_m;
    options.sampling = object.properties.sampling;
    options.stop = _selector.stop;
    return options;
}

double PointAssembler::fittingSize_m(const HapticObject& object, double width_m, bool mayGrow) const
{
    haptics::LargeModel model{*object.mesh, object.pose, width_m};
    const haptics::SamplerOptions sampling = samplerOptions(object);
    if (sampling.sampling == haptics::Sampling::SURFACE) model.spacing_m = sampling.spacing_m;
    model.mayGrow = mayGrow;
    return haptics::fittingSize_m(model,
                                  _workspace,
                                  haptics::ArrayFront(_array.positions, _array.normals),
                                  _selector.maxPoints);
}

// An object that is a single focus gets all of the sound: with wrong units, it may hurt.
void PointAssembler::tellIfSmall(const SceneSnapshot& snapshot, const HapticObject& object)
{
    const double limit_m = 0.5 * _options.wavelength_m;
    const haptics::TriangleMesh& mesh = *object.mesh;
    if (object.properties.sampling == haptics::Sampling::POINTS ||
        !haptics::isOneFocus(mesh, _options.wavelength_m))
        return;
    // Small parts of a larger whole are normal.
    Eigen::Matrix<double, 3, 8> corners = object.pose * boxCorners(mesh.vertices);
    Eigen::AlignedBox3d box;
    for (const HapticObject& part : snapshot.objects)
    {
        if (part.touchId() != object.touchId() || !part.mesh || part.mesh->vertices.cols() == 0)
            continue;
        corners = part.pose * boxCorners(part.mesh->vertices);
        for (int i = 0; i < 8; ++i)
            box.extend(Eigen::Vector3d(corners.col(i)));
    }
    if (!(box.sizes().maxCoeff() < limit_m)) return;
    const double width_m = mesh.extent().maxCoeff();
    const auto known = _oneFocus.before.find(object.id);
    const bool isNew = known == _oneFocus.before.end();
    const double size_m = isNew ? fittingSize_m(object, width_m, true) : 0.0;
    _oneFocus.now[object.id] =
        isNew ? haptics::pointsAtSize(mesh, samplerOptions(object), size_m, _selector.maxPoints)
              : known->second;
    const base::Topic topic{base::MessageCode::OBJECT_SMALL, object.touchId()};
    if (!_messages.note(topic) || !isNew) return;
    _messages.say(
        topic,
        base::about(
            topic.code,
            object.path,
            fmt::format(
                "is {:.3g} m wide, under half a wavelength ({:.2g} m): "
                "it is one focus, and no louder than one point of something larger{}",
                width_m,
                limit_m,
                unitAndSize("; ", width_m, snapshot.metresPerUnit, limit_m, size_m, size_m)),
            object.origin));
}

void PointAssembler::holdSmall(const SceneSnapshot& snapshot, haptics::ControlPoints& points) const
{
    if (_oneFocus.now.empty()) return;
    std::vector<int> small;
    std::set<std::uint64_t> felt;
    int whole = 0;
    for (int i = 0; i < points.size(); ++i)
    {
        const int object = points.object[static_cast<std::size_t>(i)];
        const std::uint64_t id = snapshot.objects[static_cast<std::size_t>(object)].id;
        const auto found = _oneFocus.now.find(id);
        if (found == _oneFocus.now.end()) continue;
        small.push_back(i);
        if (felt.insert(id).second) whole += found->second;
    }
    haptics::holdToShare(small, whole, _options.loudness, _array, _options.medium, points);
}

// Models in millimetres or centimetres are common; an object far wider than the array is probably
// one.
void PointAssembler::tellIfLarge(const HapticObject& object, double metresPerUnit)
{
    const double width_m = widths(object.mesh->vertices).maxCoeff();
    const double array_m = widths(_array.positions).maxCoeff();
    if (!std::isfinite(width_m) || width_m < kNarrow * array_m) return;
    const haptics::ArrayFront front(_array.positions, _array.normals);
    const Eigen::Vector3d extent_m = widths(object.pose * boxCorners(object.mesh->vertices));
    if (!haptics::hasRoom(extent_m, _workspace, front)) _wholes.large.insert(object.touchId());
    if (!(width_m > kWide * array_m) || !(array_m > 0.0)) return;
    const base::Topic topic{base::MessageCode::OBJECT_UNITS, object.touchId()};
    if (!_messages.note(topic)) return;
    const double size_m = fittingSize_m(object, width_m);
    _messages.say(topic,
                  base::about(topic.code,
                              object.path,
                              fmt::format("is {:.3g} m wide, the array {:.3g} m{}",
                                          width_m,
                                          array_m,
                                          unitAndSize(": ",
                                                      width_m,
                                                      metresPerUnit,
                                                      0.5 * _options.wavelength_m,
                                                      size_m > 0.0 ? size_m : array_m,
                                                      size_m)),
                              object.origin));
}

// True if the object is so large that its faces are out of reach on all sides.
bool PointAssembler::isAround(const HapticObject& object) const
{
    const Eigen::Matrix<double, 3, 8> corners = object.pose * boxCorners(object.mesh->vertices);
    const Eigen::Vector3d middle = _array.positions.rowwise().mean();
    return (corners.rowwise().minCoeff().array() <= middle.array()).all() &&
           (corners.rowwise().maxCoeff().array() >= middle.array()).all();
}

void PointAssembler::tellLarge(const HapticObject& object)
{
    const double width_m = widths(object.mesh->vertices).maxCoeff();
    if (width_m > kWide * widths(_array.positions).maxCoeff()) return; // reported already
    const base::Topic topic{base::MessageCode::OBJECT_LARGE, object.touchId()};
    if (!_messages.note(topic)) return;
    const haptics::ArrayFront front(_array.positions, _array.normals);
    const std::string fits = proposal(fittingSize_m(object, width_m));
    _messages.say(topic,
                  base::about(topic.code,
                              object.path,
                              fmt::format("is {:.3g} m wide, larger than the workspace of "
                                          "{:.2g} m{}{}",
                                          width_m,
                                          haptics::roomInside_m(_workspace, front),
                                          fits.empty() ? "" : "; ",
                                          fits),
                              object.origin));
}

// The end of a message on an object that is elsewhere; empty if there was room for it.
std::string PointAssembler::alsoLarge(const HapticObject& object) const
{
    const double width_m = widths(object.mesh->vertices).maxCoeff();
    const haptics::ArrayFront front(_array.positions, _array.normals);
    const Eigen::Vector3d extent_m = widths(object.pose * boxCorners(object.mesh->vertices));
    if (haptics::hasRoom(extent_m, _workspace, front)) return {};
    const std::string fits = proposal(fittingSize_m(object, width_m));
    return fmt::format("; it is {:.3g} m wide, too, and the workspace {:.2g} m{}{}",
                       width_m,
                       haptics::roomInside_m(_workspace, front),
                       fits.empty() ? "" : ": ",
                       fits);
}

// An object is felt if one of its parts is; a part that moves by itself comes and goes.
void PointAssembler::tellLeftOut(const SceneSnapshot& snapshot,
                                 const haptics::SelectionReport& report)
{
    const auto objectOf = [&](std::size_t i) -> const HapticObject&
    { return snapshot.objects[static_cast<std::size_t>(_posed[i].object)]; };
    bool isOfLarge = false;
    std::vector<bool> isWhole(snapshot.objects.size());
    for (std::size_t i = 0; i < _posed.size(); ++i)
    {
        const haptics::LeftOutPoints& left = report.leftOut[i];
        const std::uint64_t whole = objectOf(i).touchId();
        if (report.perObject[i] > 0) _wholes.felt.insert(whole);
        if (left.overBudget > 0) isOfLarge = isOfLarge || _wholes.large.count(whole) > 0;
        isWhole[static_cast<std::size_t>(_posed[i].object)] =
            left.outOfWorkspace + left.overBudget == 0;
    }
    for (std::size_t i = 0; i < snapshot.objects.size(); ++i)
    {
        const HapticObject& object = snapshot.objects[i];
        // An object that fits except for empty corners of its box is felt completely.
        if (!isWhole[i] && _wholes.large.count(object.touchId()) > 0) tellLarge(object);
    }
    if (report.overBudget > 0 && !isOfLarge)
        _messages.note(
            {base::MessageCode::POINTS_BUDGET},
            {base::MessageCode::POINTS_BUDGET,
             fmt::format("more points than the budget of {}; objects of lower priority get fewer",
                         _selector.maxPoints)});
    tellUnfelt(snapshot, report);
}

// Names the first of the objects without any felt point.
void PointAssembler::tellUnfelt(const SceneSnapshot& snapshot,
                                const haptics::SelectionReport& report)
{
    const auto objectOf = [&](std::size_t i) -> const HapticObject&
    { return snapshot.objects[static_cast<std::size_t>(_posed[i].object)]; };
    std::vector<base::Topic> unfelt;
    const HapticObject* first = nullptr;
    for (std::size_t i = 0; i < _posed.size(); ++i)
    {
        const std::uint64_t whole = objectOf(i).touchId();
        if (_posed[i].positions.cols() == 0 ||
            _wholes.felt.count(whole) + _wholes.large.count(whole) > 0)
            continue;
        const base::Topic topic{base::MessageCode::OBJECT_UNFELT, whole};
        if (!_messages.note(topic)) continue;
        if (!first) first = &objectOf(i);
        unfelt.push_back(topic);
    }
    if (!first) return;
    haptics::LeftOutPoints ofFirst;
    for (std::size_t i = 0; i < _posed.size(); ++i)
        if (objectOf(i).touchId() == first->touchId()) ofFirst += report.leftOut[i];
    _messages.sayOfAll(
        unfelt,
        base::about(base::MessageCode::OBJECT_UNFELT,
                    first->path,
                    fmt::format("none of its points can be felt where it is (0 of {} points: {})",
                                ofFirst.total(),
                                ofFirst.summary()),
                    first->origin));
}

void PointAssembler::tellUnreachable(const SceneSnapshot& snapshot, const AssembledPoints& out)
{
    constexpr const char* kPart = "part";
    struct Told
    {
        std::vector<base::Topic> topics;
        const HapticObject* first = nullptr;
    };
    const auto code = base::MessageCode::OBJECT_UNREACHABLE;
    Told wholes;
    Told parts;
    for (std::size_t i = 0; i < snapshot.objects.size(); ++i)
    {
        const HapticObject& object = snapshot.objects[i];
        const std::uint64_t whole = object.touchId();
        // An object that had a part out of reach may have it there again.
        _messages.keepNoted({code, whole, kPart});
        if (!out.objects[i].isUnreachable) continue;
        if (_wholes.large.count(whole) > 0) // this is the reason
        {
            tellLarge(object);
            continue;
        }
        const bool isPart = _wholes.felt.count(whole) > 0;
        const base::Topic topic{code, whole, isPart ? kPart : ""};
        if (!_messages.note(topic)) continue;
        Told& told = isPart ? parts : wholes;
        told.topics.push_back(topic);
        if (!told.first) told.first = &object;
    }
    const auto say = [&](const Told& told, const std::string& what)
    {
        if (told.first)
            _messages.sayOfAll(told.topics,
                               base::about(code, told.first->path, what, told.first->origin));
    };
    say(wholes,
        "is out of the array's reach; it can't be felt there" +
            (wholes.first ? alsoLarge(*wholes.first) : ""));
    say(parts, "a part of it that moves is out of the array's reach; it can't be felt there");
}

} // namespace midair::bridge

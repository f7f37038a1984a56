// What a PointAssembler tells of objects that aren't felt as they are meant to be.
#include "engine-bridge/pipeline/PointAssembler.h"
#include "haptics/base/text/MessageLog.h"
#include "haptics/points/FittingSize.h"
#include "haptics/sequence/FocusShare.h"

#include <cmath>
#include <optional>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

/// Objects this many times as wide as the array are probably in other units.
constexpr double kWide = 10.0;
/// Objects below this share of the array's width are never too large for it.
constexpr double kNarrow = 0.25;

Eigen::Vector3d widths(const Eigen::Matrix3Xd& places)
{
    return places.rowwise().maxCoeff() - places.rowwise().minCoeff();
}

std::string fitting(double size_m)
{
    return size_m > 0.0 ? fmt::format("size={:g} fits", size_m) : "";
}

} // namespace

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

void PointAssembler::tellOnce(base::MessageCode code,
                              const HapticObject& object,
                              const std::string& what)
{
    if (_states.note(code, object.touchId(), base::withoutNumbers(what)))
        _messages.say(base::about(code, object.path, what));
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

// What is one focus alone has all of the sound: in metres what was meant in others, it may hurt.
void PointAssembler::tellIfSmall(const SceneSnapshot& snapshot, const HapticObject& object)
{
    const double limit_m = 0.5 * _options.wavelength_m;
    const haptics::TriangleMesh& mesh = *object.mesh;
    if (object.properties.sampling == haptics::Sampling::POINTS ||
        !haptics::isOneFocus(mesh, _options.wavelength_m))
        return;
    // Small parts of a whole that isn't are as they should be.
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
    if (!_states.note(base::MessageCode::OBJECT_SMALL, object.touchId()) || !isNew) return;
    std::string ask;
    if (size_m > 0.0)
        ask = fmt::format("; should metresPerUnit be {:g}, not {:g}? size={:g} fits",
                          snapshot.metresPerUnit *
                              std::pow(10.0, std::floor(std::log10(size_m / width_m) + 1e-9)),
                          snapshot.metresPerUnit,
                          size_m);
    _messages.say(base::about(base::MessageCode::OBJECT_SMALL,
                              object.path,
                              fmt::format("is {:.3g} m wide, under half a wavelength ({:.2g} m): "
                                          "it is one focus, and no louder than one point of "
                                          "something larger{}",
                                          width_m,
                                          limit_m,
                                          ask)));
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
    haptics::holdToShare(small, whole, _options.loudness, _array, haptics::Medium(), points);
}

// Models in millimetres or centimetres are common; what is far wider than the array is probably
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
    if (!_states.note(base::MessageCode::OBJECT_UNITS, object.touchId())) return;
    // A power of ten with which it is no wider than the array.
    const double factor = std::pow(10.0, std::floor(std::log10(array_m / width_m) + 1e-9));
    const std::string fits = fitting(fittingSize_m(object, width_m));
    _messages.say(base::about(base::MessageCode::OBJECT_UNITS,
                              object.path,
                              fmt::format("is {:.3g} m wide, the array {:.3g} m: should "
                                          "metresPerUnit be {:g}, not {:g}?{}{}",
                                          width_m,
                                          array_m,
                                          metresPerUnit * factor,
                                          metresPerUnit,
                                          fits.empty() ? "" : " ",
                                          fits)));
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
        // Of one that fits but for empty corners of its box all is felt.
        if (isWhole[i] || _wholes.large.count(object.touchId()) == 0) continue;
        const double width_m = widths(object.mesh->vertices).maxCoeff();
        if (width_m > kWide * widths(_array.positions).maxCoeff()) continue; // told already
        if (!_states.note(base::MessageCode::OBJECT_LARGE, object.touchId())) continue;
        const haptics::ArrayFront front(_array.positions, _array.normals);
        const std::string fits = fitting(fittingSize_m(object, width_m));
        _messages.say(base::about(base::MessageCode::OBJECT_LARGE,
                                  object.path,
                                  fmt::format("is {:.3g} m wide, larger than the workspace of "
                                              "{:.2g} m{}{}",
                                              width_m,
                                              haptics::roomInside_m(_workspace, front),
                                              fits.empty() ? "" : "; ",
                                              fits)));
    }
    if (report.overBudget > 0 && !isOfLarge && _states.note(base::MessageCode::POINTS_BUDGET, 0))
        _messages.say(
            {base::MessageCode::POINTS_BUDGET,
             fmt::format("more points than the budget of {}; objects of lower priority get fewer",
                         _selector.maxPoints)});
    base::Alike unfelt;
    std::optional<std::uint64_t> first; // the one that the message names
    for (std::size_t i = 0; i < _posed.size(); ++i)
    {
        const std::uint64_t whole = objectOf(i).touchId();
        if (_posed[i].positions.cols() == 0 ||
            _wholes.felt.count(whole) + _wholes.large.count(whole) > 0)
            continue;
        if (!_states.note(base::MessageCode::OBJECT_UNFELT, whole)) continue;
        if (!first) first = whole;
        unfelt.add(objectOf(i).path);
    }
    haptics::LeftOutPoints ofFirst;
    for (std::size_t i = 0; i < _posed.size(); ++i)
        if (objectOf(i).touchId() == first) ofFirst += report.leftOut[i];
    unfelt.tell(base::MessageCode::OBJECT_UNFELT,
                fmt::format("none of its points can be felt where it is (0 of {} points: {})",
                            ofFirst.total(),
                            ofFirst.summary()),
                _messages);
}

void PointAssembler::tellUnreachable(const SceneSnapshot& snapshot, const AssembledPoints& out)
{
    constexpr const char* kPart = "part";
    base::Alike objects;
    base::Alike parts;
    for (std::size_t i = 0; i < snapshot.objects.size(); ++i)
    {
        const std::uint64_t whole = snapshot.objects[i].touchId();
        const auto code = base::MessageCode::OBJECT_UNREACHABLE;
        // One that has had a part out of reach may have it there again.
        _states.keep(code, whole, kPart);
        if (!out.objects[i].isUnreachable) continue;
        const bool isPart = _wholes.felt.count(whole) > 0;
        if (!_states.note(code, whole, isPart ? kPart : "")) continue;
        (isPart ? parts : objects).add(snapshot.objects[i].path);
    }
    objects.tell(base::MessageCode::OBJECT_UNREACHABLE,
                 "is out of the array's reach; it can't be felt there",
                 _messages);
    parts.tell(base::MessageCode::OBJECT_UNREACHABLE,
               "a part of it that moves is out of the array's reach; it can't be felt there",
               _messages);
}

} // namespace midair::bridge

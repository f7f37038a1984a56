#include "engine-bridge/display/Coincidence.h"

#include "haptics/base/Percentile.h"
#include "haptics/base/Units.h"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

using Eigen::Vector3d;

/// Median magnitude of a normal error of one coordinate, and of three, for a sigma of 1.
constexpr double kMedianOfOne = 0.67449;
constexpr double kMedianOfThree = 1.53817;

/// Sigma of a measured distance of the pupils, and of an unmeasured one around the mean of 63 mm
/// (N. A. Dodgson, "Variation and extrema of human interpupillary distance", 2004).
constexpr double kMeasuredIpd_m = 1e-3;
constexpr double kAnyIpd_m = 3.8e-3;
/// Least distance of two eyes for which their lines of sight determine a place.
constexpr double kLeastIpd_m = 1e-3;

/// First column of each part: a part always uses the same normal numbers, so that it has the same
/// errors alone and in the total.
enum FirstColumn : std::size_t
{
    OF_ARRAY = 0,
    OF_DISPLAY = 3,
    OF_EYE = 9,
    OF_IPD = 12,
    OF_AIR = 13,
    OF_MOTION = 14,
    OF_TRACKER = 17,
    COLUMNS = 20
};

/// Shift of the seen place by one cause: a constant \a bias, plus each column times a normal
/// number.
struct Shifts
{
    Vector3d bias = Vector3d::Zero();
    std::vector<Vector3d> columns;

    /// For the total: adds \a part from its column on.
    void add(const Shifts& part, FirstColumn first)
    {
        bias += part.bias;
        columns.resize(COLUMNS, Vector3d::Zero());
        for (std::size_t k = 0; k < part.columns.size(); ++k)
            columns[first + k] += part.columns[k];
    }
    void append(const Shifts& other)
    {
        columns.insert(columns.end(), other.columns.begin(), other.columns.end());
    }
    /// Shifts of equal size in all directions.
    static Shifts around(double median_m)
    {
        Shifts shifts;
        for (int axis = 0; axis < 3; ++axis)
            shifts.columns.emplace_back(Vector3d::Unit(axis) * (median_m / kMedianOfThree));
        return shifts;
    }
};

constexpr std::size_t kSamples = 1024;
using Normals = std::array<std::array<float, COLUMNS>, kSamples>;

/// The same numbers each time, so that figures change only with their input.
const Normals& normals()
{
    static const std::unique_ptr<const Normals> all = []
    {
        auto made = std::make_unique<Normals>();
        std::mt19937 lot(5);
        std::normal_distribution<float> normal;
        for (auto& one : *made)
            for (float& value : one)
                value = normal(lot);
        return made;
    }();
    return *all;
}

CoincidencePart partOf(const Shifts& shifts, FirstColumn first)
{
    std::vector<double> sizes(kSamples);
    for (std::size_t i = 0; i < kSamples; ++i)
    {
        Vector3d shift = shifts.bias;
        for (std::size_t k = 0; k < shifts.columns.size(); ++k)
            shift += static_cast<double>(normals()[i][first + k]) * shifts.columns[k];
        sizes[i] = shift.norm();
    }
    CoincidencePart part;
    part.state = CoincidencePart::KNOWN;
    part.median_mm = 1e3 * base::percentile(sizes, 0.5);
    part.most_mm = 1e3 * base::percentile(std::move(sizes), 0.95);
    return part;
}

/// Returns the place nearest to both lines; none for parallel ones.
std::optional<Vector3d>
crossing(const Vector3d& a, const Vector3d& alongA, const Vector3d& b, const Vector3d& alongB)
{
    const Vector3d u = alongA.normalized();
    const Vector3d v = alongB.normalized();
    const double uv = u.dot(v);
    const double off = 1.0 - uv * uv;
    if (!(off > 1e-12)) return {};
    const Vector3d ab = b - a;
    const double s = (ab.dot(u) - ab.dot(v) * uv) / off;
    const double t = (ab.dot(u) * uv - ab.dot(v)) / off;
    return 0.5 * (a + s * u + b + t * v);
}

/// Estimates the parts of one object.
class Estimate
{
public:
    Estimate(const CoincidenceOptions& options, const SeenObject& object) :
        _options(options),
        _object(object)
    {
        _figures.id = object.id;
        _figures.object = object.path;
    }

    CoincidenceFigures take()
    {
        if (_options.worldToArray.matrix().isIdentity(0.0))
            _figures.array.state = CoincidencePart::NONE; // the array's frame is the world
        else
            know(_figures.array, OF_ARRAY, "arrayError isn't set", around(_options.arrayError_m));
        sight();
        know(_figures.air, OF_AIR, "airError isn't set", airShifts());
        motion();
        if (_object.isTouched)
            know(_figures.tracker,
                 OF_TRACKER,
                 "trackerError isn't set",
                 around(_options.trackerError_m));
        else
            _figures.tracker.state = CoincidencePart::NONE;
        finish();
        return std::move(_figures);
    }

private:
    using Known = std::optional<Shifts>;

    static Known around(const std::optional<double>& median_m)
    {
        if (!median_m) return {};
        return Shifts::around(*median_m);
    }

    void know(CoincidencePart& part, FirstColumn first, const std::string& why, const Known& shifts)
    {
        if (!shifts) return doubt(why);
        part = partOf(*shifts, first);
        _all.add(*shifts, first);
    }

    void doubt(const std::string& why)
    {
        if (!why.empty()) _figures.unknown += (_figures.unknown.empty() ? "" : "; ") + why;
    }

    void sight()
    {
        const Viewing& seen = _options.seen;
        if (!seen.lost.empty()) return doubt(seen.lost);
        if (!seen.display) return doubt("no display is known");
        const Vector3d place = _options.worldToArray.inverse() * _object.place;
        const auto nominal = seenPlace(*seen.display, seen.head, place);
        if (!nominal) return doubt("the display doesn't show the object from the head's position");
        const bool isMono = seen.display->stereo == StereoMode::LEFT_EYE ||
                            seen.display->stereo == StereoMode::RIGHT_EYE;
        Known picture = picturePart(place);
        know(_figures.display, OF_DISPLAY, "the display's file has no accuracy_mm", picture);
        Known eye;
        if (_options.headError_m)
            eye = shiftsBy(place,
                           *_options.headError_m / kMedianOfThree,
                           3,
                           [](SightErrors& errors, int axis, double size)
                           { errors.eye[axis] = size; });
        know(_figures.eye, OF_EYE, "headError isn't set", eye);
        if (isMono)
        {
            _figures.ipd.state = CoincidencePart::NONE;
            return;
        }
        Known ipd =
            shiftsBy(place,
                     seen.display->isIpdGiven ? kMeasuredIpd_m : kAnyIpd_m,
                     1,
                     [](SightErrors& errors, int /*axis*/, double size) { errors.ipd_m = size; });
        if (ipd) ipd->bias = _options.worldToArray.linear() * (*nominal - place);
        know(_figures.ipd, OF_IPD, "the display doesn't show the object", ipd);
    }

    Known picturePart(const Vector3d& place) const
    {
        const Display& display = *_options.seen.display;
        if (!display.accuracy_m) return {};
        Known shifts = shiftsBy(place,
                                *display.accuracy_m / kMedianOfThree,
                                3,
                                [](SightErrors& errors, int axis, double size)
                                { errors.picture[axis] = size; });
        const Known turned = display.accuracy_rad
                                 ? shiftsBy(place,
                                            *display.accuracy_rad / kMedianOfThree,
                                            3,
                                            [](SightErrors& errors, int axis, double size)
                                            { errors.turn[axis] = size; })
                                 : Known(Shifts());
        if (!shifts || !turned) return {};
        shifts->append(*turned);
        return shifts;
    }

    /// Central differences over a sigma. \a set applies an error of a given size along an axis.
    template<class Set>
    Known shiftsBy(const Vector3d& place, double sigma, int axes, const Set& set) const
    {
        Shifts shifts;
        for (int axis = 0; axis < axes; ++axis)
        {
            SightErrors more;
            SightErrors less;
            set(more, axis, sigma);
            set(less, axis, -sigma);
            const Viewing& seen = _options.seen;
            const auto far = seenPlace(*seen.display, seen.head, place, more);
            const auto near = seenPlace(*seen.display, seen.head, place, less);
            if (!far || !near) return {};
            shifts.columns.emplace_back(_options.worldToArray.linear() * (0.5 * (*far - *near)));
        }
        return shifts;
    }

    // The speed of sound rises by half the relative rise of the air's absolute temperature.
    Known airShifts() const
    {
        if (!_options.airError_K || !_options.array) return {};
        const double faster = 0.5 * *_options.airError_K / base::toKelvin(_options.temperature_C);
        const auto shift = airShift(*_options.array, _object.place, faster);
        if (!shift) return {};
        Shifts shifts;
        shifts.columns.emplace_back(*shift / kMedianOfOne);
        return shifts;
    }

    // Its figures are measured; the total uses a normal error with the larger of the matching
    // sigmas.
    void motion()
    {
        constexpr double kMostOfThree = 2.7955;
        const MotionError& motion = _object.motion;
        if (!motion.isKnown) return doubt("its motion isn't known yet");
        _figures.motion = {CoincidencePart::KNOWN, 1e3 * motion.median_m, 1e3 * motion.most_m};
        _all.add(Shifts::around(
                     std::max(motion.median_m, motion.most_m * (kMedianOfThree / kMostOfThree))),
                 OF_MOTION);
    }

    void finish()
    {
        double most_mm = 0.0;
        for (const CoincidenceRow& row : kCoincidenceParts)
        {
            const CoincidencePart& part = _figures.*row.part;
            if (part.state != CoincidencePart::KNOWN || !(part.most_mm > most_mm)) continue;
            most_mm = part.most_mm;
            _figures.largest = row.name;
        }
        if (_figures.unknown.empty()) _figures.total = partOf(_all, OF_ARRAY);
    }

    const CoincidenceOptions& _options;
    const SeenObject& _object;
    CoincidenceFigures _figures;
    Shifts _all;
};

} // namespace

CoincidenceFigures coincidenceOf(const CoincidenceOptions& options, const SeenObject& object)
{
    return Estimate(options, object).take();
}

std::string textOf(const CoincidenceFigures& figures)
{
    const CoincidencePart& total = figures.total;
    if (total.state == CoincidencePart::KNOWN)
        return fmt::format("{:.1f} mm, 95 % {:.1f} mm{}",
                           total.median_mm,
                           total.most_mm,
                           figures.largest.empty() ? "" : ", mostly " + figures.largest);
    std::string known;
    for (const CoincidenceRow& row : kCoincidenceParts)
    {
        const CoincidencePart& part = figures.*row.part;
        if (part.state == CoincidencePart::KNOWN && part.most_mm > 0.0)
            known += fmt::format("; {} {:.1f} mm", row.name, part.median_mm);
    }
    return "unknown, since " + figures.unknown + known;
}

std::optional<Vector3d> seenPlace(const Display& display,
                                  const Eigen::Isometry3d& head,
                                  const Vector3d& place,
                                  const SightErrors& errors)
{
    const Picture picture(display);
    const Vector3d middle = picture.at(0.5, 0.5);
    const double angle = errors.turn.norm();
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    if (angle > 0.0) turn = Eigen::AngleAxisd(angle, errors.turn / angle).toRotationMatrix();
    const double ipd_m = std::max(display.ipd_m, kLeastIpd_m);
    std::array<Vector3d, 2> eyes;
    std::array<Vector3d, 2> pixels;
    for (const int side : {-1, 1})
    {
        const auto i = static_cast<std::size_t>(side > 0);
        const int drawn = display.stereo == StereoMode::NONE ? 0 : side;
        Eigen::Vector2d uv;
        if (!picture.meets(eyeOf(head, ipd_m, drawn), place, uv)) return {};
        pixels[i] = middle + turn * (picture.at(uv.x(), uv.y()) - middle) + errors.picture;
        eyes[i] = eyeOf(head, ipd_m + errors.ipd_m, side) + errors.eye;
    }
    return crossing(eyes[0], pixels[0] - eyes[0], eyes[1], pixels[1] - eyes[1]);
}

// At the shifted place the phase of transducer i is off by k (u_i . shift - faster r_i), which
// should be equal for all; u_i is the unit vector from it to the focus.
std::optional<Vector3d>
airShift(const haptics::TransducerArray& array, const Vector3d& focus, double faster)
{
    Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    for (Eigen::Index i = 0; i < array.size(); ++i)
    {
        const Vector3d way = focus - array.positions.col(i);
        const double r = way.norm();
        const double facing = array.normals.col(i).dot(way) / r;
        if (!(r > 0.0) || !(facing > 0.0)) continue;
        Eigen::Vector4d row;
        row << way / r, -1.0;
        normal += (facing / r) * row * row.transpose();
        right += (facing / r) * faster * r * row;
    }
    const Eigen::Vector4d solved = normal.inverse() * right;
    if (!solved.allFinite()) return {};
    return Vector3d(solved.head<3>());
}

} // namespace midair::bridge

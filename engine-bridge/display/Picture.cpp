#include "engine-bridge/display/Picture.h"

#include <cmath>
#include <numeric>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

using Eigen::Vector3d;

constexpr int kBoxSteps = 9; ///< per edge of the box, for share()

Vector3d acrossPlane(const Optic& plane, const Vector3d& place)
{
    return place - 2.0 * plane.normal.dot(place - plane.point) * plane.normal;
}

Vector3d turnedAtPlane(const Optic& plane, const Vector3d& direction)
{
    return direction - 2.0 * plane.normal.dot(direction) * plane.normal;
}

Vector3d middleOfOutline(const std::vector<Vector3d>& outline)
{
    Vector3d sum = Vector3d::Zero();
    for (const Vector3d& corner : outline)
        sum += corner;
    return outline.empty() ? sum : Vector3d(sum / static_cast<double>(outline.size()));
}

/// The normal of the plane through \a eye and the edge \a i of \a outline, towards its \a middle.
Vector3d sightPlane(const std::vector<Vector3d>& outline,
                    std::size_t i,
                    const Vector3d& middle,
                    const Vector3d& eye)
{
    const Vector3d normal = (outline[i] - eye).cross(outline[(i + 1) % outline.size()] - eye);
    return normal.dot(middle - eye) < 0.0 ? Vector3d(-normal) : normal;
}

/// Returns the part of the convex \a polygon with \a normal . (place - origin) >= 0 (Sutherland,
/// Hodgman).
std::vector<Vector3d>
cutPolygon(const std::vector<Vector3d>& polygon, const Vector3d& normal, const Vector3d& origin)
{
    std::vector<Vector3d> kept;
    for (std::size_t i = 0; i < polygon.size(); ++i)
    {
        const Vector3d& a = polygon[i];
        const Vector3d& b = polygon[(i + 1) % polygon.size()];
        const double da = normal.dot(a - origin);
        const double db = normal.dot(b - origin);
        if (da >= 0.0) kept.push_back(a);
        if ((da >= 0.0) != (db >= 0.0)) kept.emplace_back(a + da / (da - db) * (b - a));
    }
    return kept;
}

} // namespace

Picture::Picture(const Display& display) :
    _corner(display.lowerLeft),
    _right(display.lowerRight - display.lowerLeft),
    _up(display.upperLeft - display.lowerLeft),
    _front(_right.cross(_up).normalized()),
    _pixelAspect(static_cast<double>(display.width) / display.height)
{
    // A screen skewed within the allowed 1 % is replaced by the nearest rectangle: right and up
    // keep their plane, their bisectors and their lengths.
    const double skew = 0.5 * std::asin(_right.normalized().dot(_up.normalized()));
    const Vector3d middle = at(0.5, 0.5);
    const Vector3d right = Eigen::AngleAxisd(-skew, _front) * _right;
    const Vector3d up = Eigen::AngleAxisd(skew, _front) * _up;
    _right = right;
    _up = up;
    _corner = middle - 0.5 * (_right + _up);
    for (const Optic& optic : display.optics)
    {
        _corner = acrossPlane(optic, _corner);
        _right = turnedAtPlane(optic, _right);
        _up = turnedAtPlane(optic, _up);
        // A half mirror reflects the light's direction. A plate reverses the component along its
        // plane, and the light continues on the other side.
        const bool isMirror = optic.kind == Optic::Kind::HALF_MIRROR;
        _front = turnedAtPlane(optic, _front) * (isMirror ? 1.0 : -1.0);
        if (isMirror) _isFlipped = !_isFlipped;
    }
    for (std::size_t k = display.optics.size(); k-- > 0;)
    {
        Optic optic = display.optics[k];
        for (std::size_t j = k + 1; j < display.optics.size(); ++j)
        {
            const Optic& later = display.optics[j];
            optic.point = acrossPlane(later, optic.point);
            optic.normal = turnedAtPlane(later, optic.normal);
            for (Vector3d& corner : optic.outline)
                corner = acrossPlane(later, corner);
        }
        const Vector3d middleHere = middleOfOutline(optic.outline);
        _seen.push_back({std::move(optic), middleHere});
    }
}

bool Picture::meets(const Vector3d& eye, const Vector3d& place, Eigen::Vector2d& uv) const
{
    const Vector3d ray = place - eye;
    const double towards = -_front.dot(ray);
    const double away = _front.dot(eye - _corner);
    if (!(towards > 1e-12) || !(away > 0.0)) return false;
    const Vector3d there = eye + away / towards * ray - _corner;
    uv = {there.dot(_right) / _right.squaredNorm(), there.dot(_up) / _up.squaredNorm()};
    return true;
}

std::string Picture::swapped() const
{
    const double aspect = std::log(_right.norm() / _up.norm());
    const double pixels = std::log(_pixelAspect);
    if (std::abs(aspect + pixels) < 0.05 && std::abs(aspect - pixels) > 0.1)
        return "lowerRight_m and upperLeft_m are swapped";
    if (_up.z() < -0.1 * _up.norm()) return "lower and upper corners are swapped";
    return "left and right corners are swapped";
}

std::string Picture::whyUnseen(const Vector3d& eye) const
{
    const double before_m = _front.dot(eye - _corner);
    if (!(before_m > 1e-3))
        return fmt::format(
            "the eye is {:.3g} m behind the picture, most often because {}", -before_m, swapped());
    return whyNoLight(eye, at(0.5, 0.5));
}

/// Follows the line of sight from \a eye to \a place in the picture: \c t is 0 at the eye and 1
/// there. At a plate the light comes from beyond it, although the eye sees its source in front of
/// it: the path turns back.
std::string Picture::whyNoLight(const Vector3d& eye, const Vector3d& place) const
{
    const Vector3d ray = place - eye;
    double t = 0.0;
    double way = 1.0;
    for (std::size_t i = 0; i < _seen.size(); ++i)
    {
        const Optic& optic = _seen[i].optic;
        const double next = optic.normal.dot(optic.point - eye) / optic.normal.dot(ray);
        const bool isMirror = optic.kind == Optic::Kind::HALF_MIRROR;
        const std::size_t number = _seen.size() - 1 - i;
        const bool comes = (next - t) * way > 0.0; // also false for NaN
        t = next;
        if (!isMirror) way = -way;
        const bool isLast = i + 1 == _seen.size();
        if (!comes || (isLast && !((1.0 - t) * way > 0.0)))
            return fmt::format("no light of the screen reaches the eye by optics[{}]: {}",
                               number,
                               isMirror ? "both must be on the same side of a half mirror"
                                        : "they must be on two sides of a plate, and the eye "
                                          "farther from it than the picture");
    }
    return {};
}

bool Picture::shows(const Vector3d& eye, const Vector3d& place) const
{
    Eigen::Vector2d uv;
    if (!meets(eye, place, uv) || uv.minCoeff() < 0.0 || uv.maxCoeff() > 1.0) return false;
    const Vector3d there = at(uv.x(), uv.y());
    for (const Seen& seen : _seen)
        for (std::size_t i = 0; i < seen.optic.outline.size(); ++i)
            if (sightPlane(seen.optic.outline, i, seen.middle, eye).dot(there - eye) < 0.0)
                return false;
    return whyNoLight(eye, there).empty();
}

double Picture::share(const Vector3d& eye, const Vector3d& low, const Vector3d& high) const
{
    int shown = 0;
    for (int i = 0; i < kBoxSteps * kBoxSteps * kBoxSteps; ++i)
    {
        const int row = i / kBoxSteps;
        const int layer = row / kBoxSteps;
        const Eigen::Array3d step(i % kBoxSteps, row % kBoxSteps, layer);
        const Eigen::Array3d place =
            low.array() + (high - low).array() * step / static_cast<double>(kBoxSteps - 1);
        if (shows(eye, place.matrix())) ++shown;
    }
    return shown / static_cast<double>(kBoxSteps * kBoxSteps * kBoxSteps);
}

std::vector<Vector3d> Picture::visiblePart(const Vector3d& eye) const
{
    if (!whyUnseen(eye).empty()) return {};
    std::vector<Vector3d> part = {at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)};
    for (const Seen& seen : _seen)
        for (std::size_t i = 0; i < seen.optic.outline.size(); ++i)
            part = cutPolygon(part, sightPlane(seen.optic.outline, i, seen.middle, eye), eye);
    return part.size() < 3 ? std::vector<Vector3d>() : part;
}

EyeView eyeView(const Picture& picture, const Vector3d& eye, double near_m, double far_m)
{
    // The corner that the eye sees at the lower left, and the picture's basis as seen from there:
    // for a flipped picture the projection is that of the seen picture, followed by turnedAtPlane
    // in x, so that the view stays rigid.
    const Vector3d corner = picture.at(picture.isFlipped() ? 1.0 : 0.0, 0.0);
    const Vector3d across = picture.right() * (picture.isFlipped() ? -1.0 : 1.0);
    EyeView result;
    Eigen::Matrix3d axes; // rows
    axes.row(0) = across.normalized();
    axes.row(1) = picture.up().normalized();
    axes.row(2) = picture.front();
    result.view = Eigen::Isometry3d::Identity();
    result.view.linear() = axes;
    result.view.translation() = -(axes * eye);
    // Kooima's generalised perspective projection: the frustum through the picture's edges, whose
    // plane is at the distance d in front of the eye.
    const Vector3d low = result.view * corner;
    const Vector3d high = result.view * Vector3d(corner + across + picture.up());
    const double d = -low.z();
    const double left = low.x() * near_m / d;
    const double right = high.x() * near_m / d;
    const double bottom = low.y() * near_m / d;
    const double top = high.y() * near_m / d;
    result.projection.setZero();
    result.projection(0, 0) = 2.0 * near_m / (right - left);
    result.projection(0, 2) = (right + left) / (right - left);
    result.projection(1, 1) = 2.0 * near_m / (top - bottom);
    result.projection(1, 2) = (top + bottom) / (top - bottom);
    result.projection(2, 2) = -(far_m + near_m) / (far_m - near_m);
    result.projection(2, 3) = -2.0 * far_m * near_m / (far_m - near_m);
    result.projection(3, 2) = -1.0;
    if (picture.isFlipped()) result.projection.row(0) *= -1.0;
    return result;
}

} // namespace midair::bridge

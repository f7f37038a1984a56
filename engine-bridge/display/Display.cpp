#include "engine-bridge/display/Display.h"

#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/Units.h"
#include "haptics/base/text/JsonValue.h"
#include "haptics/base/text/Range.h"
#include "haptics/base/text/Words.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

using base::InputError;
using base::JsonValue;
using Eigen::Vector3d;

constexpr std::size_t kMostDisplayBytes = std::size_t(1) << 20;
constexpr double kFarthestCorner_m = 100.0; ///< from the world's origin; farther means a wrong unit
constexpr double kMostSkew = 0.01;          ///< tolerance for a rectangle
constexpr double kLeastEdge_m = 0.005;      ///< of a screen
constexpr double kOffPlane_m = 0.001;       ///< tolerance for corners of an outline
constexpr const char* kCornerPlace = "a place [x, y, z] in metres, each within 100";

/// Deviation of the edges at \a corner from a right angle: the cosine between them.
double skewAt(const Vector3d& corner, const Vector3d& a, const Vector3d& b)
{
    return std::abs((a - corner).normalized().dot((b - corner).normalized()));
}

void checkCorners(const Display& display, const std::string& source)
{
    const auto fail = [&](const std::string& what)
    { throw InputError(source + ": screen " + what); };
    const Vector3d* const corners[] = {&display.lowerLeft, &display.lowerRight, &display.upperLeft};
    const char* const names[] = {"lowerLeft_m", "lowerRight_m", "upperLeft_m"};
    for (int i = 0; i < 3; ++i)
        if (!corners[i]->allFinite() || corners[i]->cwiseAbs().maxCoeff() > kFarthestCorner_m)
            fail(fmt::format("{} isn't {}", names[i], kCornerPlace));
    const Vector3d& left = display.lowerLeft;
    const double across_m = (display.lowerRight - left).norm();
    const double up_m = (display.upperLeft - left).norm();
    if (!(std::min(across_m, up_m) >= kLeastEdge_m))
        fail(fmt::format("is {:.4g} m by {:.4g} m; each edge must be at least {} m",
                         across_m,
                         up_m,
                         kLeastEdge_m));
    const double skew = skewAt(left, display.lowerRight, display.upperLeft);
    if (skew <= kMostSkew) return;
    std::string hint;
    if (skewAt(display.lowerRight, left, display.upperLeft) <= kMostSkew)
        hint = ": lowerLeft_m and lowerRight_m are swapped";
    else if (skewAt(display.upperLeft, left, display.lowerRight) <= kMostSkew)
        hint = ": lowerLeft_m and upperLeft_m are swapped";
    fail(fmt::format(
        "corners are no rectangle within 1 %: at lowerLeft_m is an angle of {:.1f} "
        "degrees{}",
        std::acos(
            (display.lowerRight - left).normalized().dot((display.upperLeft - left).normalized())) *
            57.29577951308232,
        hint));
}

void checkOptic(Optic& optic, const std::string& name)
{
    const auto fail = [&](const std::string& what) { throw InputError(name + " " + what); };
    if (!optic.point.allFinite()) fail(std::string("point_m isn't ") + kCornerPlace);
    if (!optic.normal.allFinite() || !(optic.normal.norm() > 1e-9))
        fail("normal isn't a direction [x, y, z] that is not zero");
    optic.normal.normalize();
    const std::size_t n = optic.outline.size();
    if (n == 0) return;
    if (n < 3) fail(fmt::format("outline_m has {} corners; it must have at least 3", n));
    for (std::size_t i = 0; i < n; ++i)
    {
        const double off_m = std::abs(optic.normal.dot(optic.outline[i] - optic.point));
        if (!(off_m <= kOffPlane_m))
            fail(fmt::format("outline_m[{}] is {:.4g} m off the plane of point_m and normal; at "
                             "most {} m are possible",
                             i,
                             off_m,
                             kOffPlane_m));
    }
    // All corners must turn the same way.
    int turns = 0;
    for (std::size_t i = 0; i < n; ++i)
    {
        const Vector3d& b = optic.outline[(i + 1) % n];
        const Vector3d& c = optic.outline[(i + 2) % n];
        const double turn = optic.normal.dot((b - optic.outline[i]).cross(c - b));
        if (std::abs(turn) > 1e-12)
            turns += turn > 0.0 ? 1 : -1;
        else
            fail(fmt::format("outline_m[{}] is on a line with its neighbours", (i + 1) % n));
    }
    if (std::abs(turns) != static_cast<int>(n))
        fail("outline_m isn't convex: its corners must go around, with no dent");
}

Vector3d cornerOf(const JsonValue& value)
{
    return value.vector(3, kFarthestCorner_m, kCornerPlace);
}

StereoMode stereoModeOf(const JsonValue& value)
{
    const std::string name = value.string();
    const auto& names = stereoNames();
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end())
        value.wrong(
            fmt::format("one of {}{}", fmt::join(names, ", "), base::didYouMean(name, names)));
    return static_cast<StereoMode>(found - names.begin());
}

Optic opticOf(const JsonValue& value)
{
    value.object({"kind", "point_m", "normal", "outline_m"});
    Optic optic;
    const JsonValue kind = value.required("kind", "half-mirror or plate");
    const std::string name = kind.string();
    if (name == "plate")
        optic.kind = Optic::Kind::PLATE;
    else if (name != "half-mirror")
        kind.wrong("half-mirror or plate" + base::didYouMean(name, {"half-mirror", "plate"}));
    optic.point = cornerOf(value.required("point_m", kCornerPlace));
    optic.normal = value.required("normal", "a direction [x, y, z]").direction();
    if (const auto outline = value.find("outline_m"))
    {
        outline->list("a list of at least 3 places", 64);
        for (std::size_t i = 0; i < outline->size(); ++i)
            optic.outline.push_back(cornerOf((*outline)[i]));
        if (optic.outline.size() < 3) outline->wrong("a list of at least 3 places");
    }
    return optic;
}

void readScreen(const JsonValue& screen, Display& display)
{
    screen.object({"lowerLeft_m", "lowerRight_m", "upperLeft_m", "upperRight_m", "pixels"});
    display.lowerLeft = cornerOf(screen.required("lowerLeft_m", kCornerPlace));
    display.lowerRight = cornerOf(screen.required("lowerRight_m", kCornerPlace));
    display.upperLeft = cornerOf(screen.required("upperLeft_m", kCornerPlace));
    const char* const right = "[width, height], whole numbers, 16 .. 32768";
    const JsonValue pixels = screen.required("pixels", right);
    if (!pixels.isList() || pixels.size() != 2) pixels.wrong(right);
    display.width = pixels[0].integer(16, 32768, right);
    display.height = pixels[1].integer(16, 32768, right);
    const auto fourth = screen.find("upperRight_m");
    if (!fourth) return;
    const Vector3d expected = display.lowerRight + display.upperLeft - display.lowerLeft;
    const double off_m = (cornerOf(*fourth) - expected).norm();
    const double most_m = kMostSkew * (display.lowerRight - display.upperLeft).norm();
    if (off_m > most_m)
        fourth->fail(
            fmt::format("is {:.4g} m from where it makes a rectangle of the other corners, "
                        "[{:.4g}, {:.4g}, {:.4g}]; within 1 % are {:.4g} m",
                        off_m,
                        expected.x(),
                        expected.y(),
                        expected.z(),
                        most_m));
}

} // namespace

const std::vector<std::string>& stereoNames()
{
    static const std::vector<std::string> names = {"none",
                                                   "quad-buffer",
                                                   "anaglyph",
                                                   "side-by-side",
                                                   "top-bottom",
                                                   "left-eye",
                                                   "right-eye",
                                                   "horizontal-interlace",
                                                   "vertical-interlace",
                                                   "checkerboard"};
    return names;
}

void checkDisplay(Display& display, const std::string& source)
{
    checkCorners(display, source);
    for (std::size_t i = 0; i < display.optics.size(); ++i)
        checkOptic(display.optics[i], fmt::format("{}: optics[{}]", source, i));
    std::string error;
    const std::string owner = source + ": ";
    if (!base::RangeCheck(owner.c_str())
             .within("ipd_m", display.ipd_m, 0.0, 0.1)
             .within("pixels[0]", display.width, 16, 32768)
             .within("pixels[1]", display.height, 16, 32768)
             .passed(&error))
        throw InputError(error);
}

Display readDisplay(const std::string& text, const std::string& source)
{
    const JsonValue::Json file = base::parseJson(text, source);
    const JsonValue root(source, file);
    root.object(
        {"about", "screen", "optics", "eye", "ipd_m", "stereo", "accuracy_mm", "accuracy_deg"});
    Display display;
    readScreen(root.required("screen", "an object with corners and pixels"), display);
    if (const auto optics = root.find("optics"))
    {
        optics->list("a list of half mirrors and plates", 8);
        for (std::size_t i = 0; i < optics->size(); ++i)
            display.optics.push_back(opticOf((*optics)[i]));
    }
    display.eye = root.required("eye", "a head source: \"fixed X Y Z\" ..").string();
    if (const auto ipd = root.find("ipd_m"))
    {
        display.ipd_m = ipd->number(0.0, 0.1, "0 .. 0.1 m");
        display.isIpdGiven = true;
    }
    if (const auto place = root.find("accuracy_mm"))
        display.accuracy_m = 1e-3 * place->number(0.0, 1000.0, "0 .. 1000 mm");
    if (const auto turn = root.find("accuracy_deg"))
        display.accuracy_rad = base::toRadians(turn->number(0.0, 90.0, "0 .. 90 degrees"));
    if (const auto stereo = root.find("stereo")) display.stereo = stereoModeOf(*stereo);
    checkDisplay(display, source);
    return display;
}

std::string withScreen(const std::string& text, const std::string& source, const Display& display)
{
    JsonValue::Json file = base::parseJson(text, source);
    JsonValue::Json& screen = file["screen"];
    const auto set = [&](const char* key, const Vector3d& corner)
    {
        screen[key] = {std::round(corner.x() * 1e6) / 1e6,
                       std::round(corner.y() * 1e6) / 1e6,
                       std::round(corner.z() * 1e6) / 1e6};
    };
    set("lowerLeft_m", display.lowerLeft);
    set("lowerRight_m", display.lowerRight);
    set("upperLeft_m", display.upperLeft);
    if (screen.contains("upperRight_m"))
        set("upperRight_m", display.lowerRight + display.upperLeft - display.lowerLeft);
    std::string written = file.dump(2) + "\n";
    readDisplay(written, source);
    return written;
}

Display loadDisplay(const std::string& path)
{
    const std::string name = base::printable(path);
    return readDisplay(
        base::readRegularFile(path, kMostDisplayBytes, "display file \"" + name + "\" "), name);
}

} // namespace midair::bridge

#include "engine-bridge/display/DisplayFit.h"

#include "engine-bridge/calibration/Calibration.h"
#include "engine-bridge/calibration/LeastSquares.h"
#include "engine-bridge/calibration/PlaceError.h"
#include "engine-bridge/display/Picture.h"
#include "haptics/base/InputError.h"
#include "haptics/base/text/Number.h"
#include "haptics/base/text/Range.h"
#include "haptics/base/text/Words.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>
#include <istream>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

using Eigen::Vector3d;

constexpr double kLineOfCrosses = 0.05; ///< second over first standard deviation: below, a line
constexpr double kHeadPlace_m = 0.1;    ///< heads nearer to each other than this count as one place
constexpr std::size_t kFewestHeads = 3;
constexpr std::size_t kFewestTouches = 3;
constexpr double kOutlierSigmas = 4.0;
constexpr std::size_t kMostTouches = 10000;

Vector3d acrossOptic(const Optic& optic, const Vector3d& place)
{
    return place - 2.0 * optic.normal.dot(place - optic.point) * optic.normal;
}

/// True if the crosses are so near to one line that the rotation about it is undetermined.
bool areOnLine(const std::vector<CrossTouch>& touches, const Display& display)
{
    Eigen::Matrix2Xd places(2, static_cast<Eigen::Index>(touches.size()));
    for (std::size_t k = 0; k < touches.size(); ++k)
        places.col(static_cast<Eigen::Index>(k)) =
            inPicture(display, displayCrosses()[static_cast<std::size_t>(touches[k].cross)])
                .head<2>();
    const Eigen::Matrix2Xd apart = places.colwise() - places.rowwise().mean();
    const Eigen::Matrix2d moments = apart * apart.transpose();
    const double half = 0.5 * moments.trace();
    const double root = std::sqrt(std::max(0.0, half * half - moments.determinant()));
    return half - root <= kLineOfCrosses * kLineOfCrosses * (half + root);
}

/// Returns the problem of the touched crosses before any fit; empty: none.
std::string wrongCrosses(const std::vector<CrossTouch>& touches, const Display& display)
{
    std::set<int> different;
    for (const CrossTouch& touch : touches)
        different.insert(touch.cross);
    if (different.size() < kFewestTouches)
        return fmt::format("{} different crosses; touch at least three that are not on one line, "
                           "better all twelve",
                           different.size());
    if (areOnLine(touches, display))
        return "the crosses lie on one line, so the rotation about it is undetermined: touch "
               "crosses of all rows and columns";
    return {};
}

DisplayFit begun(const Display& display,
                 const std::vector<CrossTouch>& touches,
                 const DisplayFitOptions& options,
                 const char* method)
{
    std::string error;
    if (!base::RangeCheck("DisplayFitOptions: ")
             .above("edge_m", options.edge_m, 0.0)
             .above("mostError_m", options.mostError_m, 0.0)
             .within("eye", options.eye, -1, 1)
             .passed(&error))
        throw base::InputError(error);
    DisplayFit fit;
    fit.display = display;
    fit.method = method;
    fit.edge_m = options.edge_m;
    for (const CrossTouch& touch : touches)
        fit.names.push_back(fmt::format("cross {}", touch.cross + 1));
    fit.residuals = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(touches.size()));
    fit.outlier.assign(touches.size(), false);
    const std::string wrong = wrongCrosses(touches, display);
    if (!wrong.empty()) fit.problems.push_back(wrong);
    return fit;
}

/// Returns one head place of each group.
std::vector<Vector3d> headPlaces(const std::vector<CrossTouch>& sights)
{
    std::vector<Vector3d> places;
    for (const CrossTouch& sight : sights)
    {
        const Vector3d here = sight.head.translation();
        const bool isNew = std::all_of(places.begin(),
                                       places.end(),
                                       [&](const Vector3d& known)
                                       { return (known - here).norm() >= kHeadPlace_m; });
        if (isNew) places.push_back(here);
    }
    return places;
}

/// Fit of sights. The line from the eye E through the fingertip F misses the seen cross by a
/// distance, expressed as the error of E and F that explains it: with errors e of E and f of F the
/// line at the cross, at the distance s |EF| from E, is off by s f + (1 - s) e.
class SightFit
{
public:
    SightFit(const Display& display,
             const std::vector<CrossTouch>& sights,
             const DisplayFitOptions& options) :
        _display(display),
        _sights(sights),
        _options(options),
        _start(pictureOf(display))
    {
        startLinear();
    }

    int unknowns() const { return _options.fitsEye ? 9 : 6; }
    /// Makes \a x the new reference: zero rotation and shift then mean the present pose.
    void rebase(Eigen::VectorXd& x)
    {
        _start = picture(x);
        x.head<6>().setZero();
    }
    Eigen::Isometry3d picture(const Eigen::VectorXd& x) const
    {
        return _start * motionOf(x.head<6>());
    }

    /// Two residuals for each of the sights \a which.
    Eigen::VectorXd residuals(const Eigen::VectorXd& x, const std::vector<int>& which) const
    {
        Eigen::VectorXd all(2 * static_cast<Eigen::Index>(which.size()));
        const Eigen::Isometry3d picture = this->picture(x);
        const Vector3d offset = _options.fitsEye ? Vector3d(x.segment<3>(6)) : Vector3d::Zero();
        for (std::size_t k = 0; k < which.size(); ++k)
        {
            const CrossTouch& sight = _sights[static_cast<std::size_t>(which[k])];
            const Vector3d eye = eyeOfSight(sight, offset);
            const Vector3d place = picture * crossOf(sight);
            const Vector3d way = sight.tip - eye;
            const Vector3d along = way.normalized();
            const Vector3d miss = place - eye;
            const double s = along.dot(miss) / way.norm();
            const Vector3d aside = along.unitOrthogonal();
            const double weight = 1.0 / std::sqrt(s * s + (1.0 - s) * (1.0 - s));
            all.segment<2>(2 * static_cast<Eigen::Index>(k)) =
                weight * Eigen::Vector2d(aside.dot(miss), along.cross(aside).dot(miss));
        }
        return all;
    }

private:
    Vector3d crossOf(const CrossTouch& sight) const
    {
        return inPicture(_display, displayCrosses()[static_cast<std::size_t>(sight.cross)]);
    }
    Vector3d eyeOfSight(const CrossTouch& sight, const Vector3d& offset) const
    {
        return eyeOf(sight.head, _display.ipd_m, _options.eye) + sight.head.linear() * offset;
    }

    /// Each line gives two equations that are linear in the picture's middle and axes; this needs
    /// no initial guess.
    void startLinear()
    {
        Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
        Eigen::Matrix<double, 9, 1> right = Eigen::Matrix<double, 9, 1>::Zero();
        for (const CrossTouch& sight : _sights)
        {
            const Vector3d eye = eyeOfSight(sight, Vector3d::Zero());
            const Vector3d along = (sight.tip - eye).normalized();
            const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - along * along.transpose();
            const Vector3d at = crossOf(sight);
            Eigen::Matrix<double, 3, 9> row;
            row << across, at.x() * across, at.y() * across;
            normal += row.transpose() * row;
            right += row.transpose() * (across * eye);
        }
        const Eigen::Matrix<double, 9, 1> found = normal.ldlt().solve(right);
        const Vector3d x = found.segment<3>(3).normalized();
        const Vector3d y = (found.tail<3>() - x.dot(found.tail<3>()) * x).normalized();
        if (!found.allFinite() || !(x.cross(y).norm() > 0.5)) return;
        _start.linear() << x, y, x.cross(y);
        _start.translation() = found.head<3>();
    }

    const Display& _display;
    const std::vector<CrossTouch>& _sights;
    const DisplayFitOptions& _options;
    Eigen::Isometry3d _start;
};

std::vector<int> allOf(std::size_t count)
{
    std::vector<int> all(count);
    for (std::size_t k = 0; k < count; ++k)
        all[k] = static_cast<int>(k);
    return all;
}

} // namespace

const std::vector<Eigen::Vector2d>& displayCrosses()
{
    static const std::vector<Eigen::Vector2d> crosses = []
    {
        std::vector<Eigen::Vector2d> made;
        for (const double v : {0.85, 0.5, 0.15})
            for (const double u : {0.1, 0.1 + 0.8 / 3.0, 0.9 - 0.8 / 3.0, 0.9})
                made.emplace_back(u, v);
        return made;
    }();
    return crosses;
}

std::vector<CrossTouch> readTouches(std::istream& in, const std::string& name, bool areSights)
{
    const std::size_t columns = areSights ? 11 : 4;
    std::vector<CrossTouch> touches;
    std::string line;
    bool isFirst = true;
    for (int number = 1; std::getline(in, line); ++number)
    {
        const std::vector<std::string> fields = base::splitColumns(line);
        if (fields.empty()) continue;
        double value = 0.0;
        const bool isHeading = isFirst && !base::parseNumber(fields.front(), value);
        isFirst = false;
        if (isHeading) continue;
        const std::string where = fmt::format("{}, line {}: ", name, number);
        if (fields.size() != columns)
            throw base::InputError(fmt::format(
                "{}{} columns; a {} has {}",
                where,
                fields.size(),
                areSights ? "sight" : "touch",
                areSights ? "eleven: cross, x, y, z of the fingertip, x, y, z, qx, qy, qz, qw of "
                            "the head"
                          : "four: cross, x, y, z of the fingertip"));
        CrossTouch touch;
        const int most = static_cast<int>(displayCrosses().size());
        if (!base::parseWhole(fields[0], touch.cross) || touch.cross < 1 || touch.cross > most)
            throw base::InputError(fmt::format(
                "{}\"{}\" is not a cross; crosses are 1 .. {}", where, fields[0], most));
        --touch.cross;
        std::array<double, 10> numbers{};
        for (std::size_t i = 1; i < columns; ++i)
            if (!base::parseNumber(fields[i], numbers[i - 1]))
                throw base::InputError(fmt::format(
                    "{}\"{}\" in column {} is not a finite number", where, fields[i], i + 1));
        touch.tip = {numbers[0], numbers[1], numbers[2]};
        if (areSights)
        {
            const Eigen::Quaterniond turn(numbers[9], numbers[6], numbers[7], numbers[8]);
            if (!(turn.norm() > 1e-6))
                throw base::InputError(where + "the head's quaternion is zero");
            touch.head.translation() = Vector3d(numbers[3], numbers[4], numbers[5]);
            touch.head.linear() = turn.normalized().toRotationMatrix();
        }
        if (touches.size() == kMostTouches)
            throw base::InputError(fmt::format(
                "{}more than {} touches, which are the most possible", where, kMostTouches));
        touches.push_back(touch);
    }
    return touches;
}

std::string touchLine(const CrossTouch& touch, bool isSight)
{
    std::string line = fmt::format(
        "{},{:.5f},{:.5f},{:.5f}", touch.cross + 1, touch.tip.x(), touch.tip.y(), touch.tip.z());
    if (!isSight) return line + "\n";
    const Vector3d at = touch.head.translation();
    const Eigen::Quaterniond turn(touch.head.linear());
    return line + fmt::format(",{:.5f},{:.5f},{:.5f},{:.6f},{:.6f},{:.6f},{:.6f}\n",
                              at.x(),
                              at.y(),
                              at.z(),
                              turn.x(),
                              turn.y(),
                              turn.z(),
                              turn.w());
}

Eigen::Vector3d inPicture(const Display& display, const Eigen::Vector2d& share)
{
    return {(share.x() - 0.5) * (display.lowerRight - display.lowerLeft).norm(),
            (share.y() - 0.5) * (display.upperLeft - display.lowerLeft).norm(),
            0.0};
}

Eigen::Isometry3d pictureOf(const Display& display)
{
    const Picture picture(display);
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    const Vector3d x = picture.right().normalized();
    const Vector3d y = picture.up().normalized();
    pose.linear() << x, y, x.cross(y);
    pose.translation() = picture.at(0.5, 0.5);
    return pose;
}

Display withPicture(const Display& display, const Eigen::Isometry3d& picture)
{
    Display placed = display;
    const auto place = [&](double u, double v)
    {
        Vector3d corner = picture * inPicture(display, {u, v});
        for (std::size_t k = display.optics.size(); k-- > 0;)
            corner = acrossOptic(display.optics[k], corner);
        return corner;
    };
    placed.lowerLeft = place(0.0, 0.0);
    placed.lowerRight = place(1.0, 0.0);
    placed.upperLeft = place(0.0, 1.0);
    return placed;
}

void concludeFit(DisplayFit& fit,
                 const Eigen::Isometry3d& picture,
                 const Eigen::MatrixXd& pose,
                 int freedom,
                 const DisplayFitOptions& options)
{
    const Display before = fit.display;
    fit.display = withPicture(before, picture);
    // A small rotation w and shift t in the picture's frame move the point r by t + w x r.
    const auto at = [&](const Vector3d& r)
    {
        Eigen::Matrix<double, 3, 6> lever;
        lever << -crossMatrix(r), Eigen::Matrix3d::Identity();
        return Eigen::Matrix3d(lever * pose.topLeftCorner<6, 6>() * lever.transpose());
    };
    const PlaceError error =
        placeError(worstAtRadius(options.edge_m, at), fit.noise, freedom, options.seed);
    fit.errorMedian_m = error.median_m;
    fit.error95_m = error.most95_m;
    if (Picture(fit.display).front().dot(Picture(before).front()) < 0.0)
        fit.problems.emplace_back(
            "the picture would be seen from behind: crosses are mirrored, left and right or upper "
            "and lower ones exchanged, or the file exchanges the screen's corners");
    if (!(fit.errorMedian_m <= options.mostError_m))
        fit.problems.push_back(fmt::format(
            "the likely error of {:.1f} mm is over {:.1f} mm: take more, farther apart and "
            "with a better tracker",
            1e3 * fit.errorMedian_m,
            1e3 * options.mostError_m));
    std::vector<std::string> left;
    for (std::size_t k = 0; k < fit.outlier.size(); ++k)
        if (fit.outlier[k]) left.push_back(fit.names[k]);
    if (!left.empty()) fit.notes.push_back(fmt::format("left out: {}", fmt::join(left, ", ")));
    fit.usable = fit.problems.empty();
}

Eigen::Vector3d DisplayFit::middle() const
{
    return Picture(display).at(0.5, 0.5);
}

std::string DisplayFit::text() const
{
    const auto out = std::count(outlier.begin(), outlier.end(), true);
    const auto all = static_cast<std::ptrdiff_t>(outlier.size());
    const char* const unit = areInPixels ? "px" : "mm";
    const double factor = areInPixels ? 1.0 : 1e3;
    std::string result = fmt::format("{}{} of {} {}\n",
                                     usable ? "calibrated from " : "not calibrated: ",
                                     all - out,
                                     all,
                                     method);
    if (noise > 0.0)
    {
        double sum = 0.0, largest = 0.0;
        for (std::size_t k = 0; k < outlier.size(); ++k)
        {
            const double one = outlier[k] ? 0.0 : residuals[static_cast<Eigen::Index>(k)];
            sum += one * one;
            largest = std::max(largest, one);
        }
        result += fmt::format("residuals: rms {:.2f} {}, largest {:.2f} {}\n",
                              factor * std::sqrt(sum / static_cast<double>(all - out)),
                              unit,
                              factor * largest,
                              unit);
        result += fmt::format("noise: {:.2f} {} a coordinate\n", factor * noise, unit);
        if (!eyeOffset.isZero())
            result += fmt::format("eye: {:.1f} mm to the right, {:.1f} mm up, {:.1f} mm back of "
                                  "where the head says\n",
                                  1e3 * eyeOffset.x(),
                                  1e3 * eyeOffset.y(),
                                  1e3 * eyeOffset.z());
        result += fmt::format("likely error at the workspace's edge, {:.0f} mm from the picture's "
                              "middle: {:.2f} mm (median), {:.2f} mm (95 %)\n",
                              1e3 * edge_m,
                              1e3 * errorMedian_m,
                              1e3 * error95_m);
    }
    for (const std::string& problem : problems)
        result += "not usable: " + problem + "\n";
    for (const std::string& note : notes)
        result += "note: " + note + "\n";
    return result;
}

DisplayFit fitTouches(const Display& display,
                      const std::vector<CrossTouch>& touches,
                      const DisplayFitOptions& options)
{
    DisplayFit fit = begun(display, touches, options, "touched crosses");
    if (!fit.problems.empty()) return fit;
    PointPairs pairs;
    const auto count = static_cast<Eigen::Index>(touches.size());
    pairs.world.resize(3, count);
    pairs.array.resize(3, count);
    for (Eigen::Index k = 0; k < count; ++k)
    {
        const CrossTouch& touch = touches[static_cast<std::size_t>(k)];
        pairs.world.col(k) = touch.tip;
        pairs.array.col(k) =
            inPicture(display, displayCrosses()[static_cast<std::size_t>(touch.cross)]);
    }
    CalibrationOptions own;
    own.edge_m = options.edge_m;
    own.seed = options.seed;
    const CalibrationReport report = calibrate(pairs, own);
    fit.residuals = report.residuals_m;
    fit.outlier = report.outlier;
    fit.noise = report.noise_m;
    if (!report.usable)
    {
        fit.problems.push_back(
            report.has(CalibrationProblem::WRONG_UNIT)
                ? fmt::format("the touched crosses are {:.3f} (+- {:.3f}) times as far apart as on "
                              "a picture of {:.3f} x {:.3f} m, which the file says: measure the "
                              "lit picture, or look for the tracker's unit",
                              1.0 / report.scale,
                              report.scaleError,
                              2.0 * inPicture(display, {1.0, 1.0}).x(),
                              2.0 * inPicture(display, {1.0, 1.0}).y())
                : report.warnings.front().text);
        fit.notes.clear();
        return fit;
    }
    // Uses calibrate()'s model of the fit's covariance.
    int kept = 0;
    Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
    for (Eigen::Index k = 0; k < count; ++k)
    {
        if (fit.outlier[static_cast<std::size_t>(k)]) continue;
        Eigen::Matrix<double, 3, 6> lever;
        lever << -crossMatrix(pairs.array.col(k)), Eigen::Matrix3d::Identity();
        normal += lever.transpose() * lever;
        ++kept;
    }
    concludeFit(
        fit, report.worldToArray.inverse(), normal.inverse(), std::max(1, 3 * kept - 6), options);
    return fit;
}

DisplayFit fitSights(const Display& display,
                     const std::vector<CrossTouch>& sights,
                     const DisplayFitOptions& options)
{
    DisplayFit fit = begun(display, sights, options, "sights");
    const std::size_t heads = headPlaces(sights).size();
    if (heads < kFewestHeads)
        fit.problems.push_back(
            fmt::format("the head was at {}, but at least three are needed, {} m apart, to find "
                        "the picture's distance",
                        heads == 1 ? std::string("one place") : fmt::format("{} places", heads),
                        kHeadPlace_m));
    if (!fit.problems.empty()) return fit;
    SightFit problem(display, sights, options);
    std::vector<int> which = allOf(sights.size());
    LeastSquares found;
    for (int round = 0; round < 6; ++round)
    {
        found = leastSquares([&](const Eigen::VectorXd& x) { return problem.residuals(x, which); },
                             round == 0 ? Eigen::VectorXd::Zero(problem.unknowns()) : found.x);
        problem.rebase(found.x);
        const auto freedom = found.residuals.size() - problem.unknowns();
        fit.noise = std::sqrt(found.residuals.squaredNorm() /
                              static_cast<double>(std::max<Eigen::Index>(1, freedom)));
        const Eigen::VectorXd all = problem.residuals(found.x, allOf(sights.size()));
        std::vector<int> next;
        for (std::size_t k = 0; k < sights.size(); ++k)
        {
            const auto at = static_cast<Eigen::Index>(k);
            fit.residuals[at] = all.segment<2>(2 * at).norm();
            fit.outlier[k] = fit.residuals[at] > kOutlierSigmas * fit.noise;
            if (!fit.outlier[k]) next.push_back(static_cast<int>(k));
        }
        if ((round > 0 && next == which) ||
            2 * next.size() < static_cast<std::size_t>(problem.unknowns()) + 2)
            break;
        which = next;
    }
    if (!found.isDetermined)
    {
        fit.problems.emplace_back("the sights don't determine the picture's position: take more of "
                                  "them, from heads that are farther apart");
        return fit;
    }
    if (options.fitsEye) fit.eyeOffset = found.x.segment<3>(6);
    concludeFit(fit,
                problem.picture(found.x),
                found.covariance,
                std::max(1, static_cast<int>(found.residuals.size()) - problem.unknowns()),
                options);
    return fit;
}

} // namespace midair::bridge

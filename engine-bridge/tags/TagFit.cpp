#include "engine-bridge/tags/TagFit.h"

#include "engine-bridge/calibration/LeastSquares.h"
#include "engine-bridge/display/Picture.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

using Eigen::Vector3d;

constexpr double kTagShare = 0.22;     ///< of the screen's height
constexpr std::size_t kFewestTags = 4; ///< in a photo
constexpr std::size_t kFewestPhotos = 3;
constexpr double kTagOutlierSigmas = 4.0;
constexpr double kLeastOutlier_px = 0.1; ///< so that exact corners have no outliers
constexpr double kMostNoise_px = 2.0;    ///< of corners; more means a mistake

/// The usable photos, with initial poses of their cameras and the picture.
class TagFitProblem
{
public:
    TagFitProblem(const Display& display, const TagRig& rig, const std::vector<TagPhoto>& photos) :
        _display(display),
        _rig(rig)
    {
        for (const ShownTag& tag : shownTags(display))
            _shown.push_back(tag);
        for (std::size_t k = 0; k < photos.size(); ++k)
            if (take(photos[k])) _numbers.push_back(static_cast<int>(k) + 1);
    }

    std::size_t photos() const { return _views.size(); }
    const std::vector<int>& numbers() const { return _numbers; } ///< of the photos, from 1
    Eigen::Index unknowns() const { return 6 + 6 * static_cast<Eigen::Index>(_views.size()); }
    Eigen::Isometry3d picture(const Eigen::VectorXd& x) const
    {
        return *_start * motionOf(x.head<6>());
    }

    /// Errors of all corners in pixels, photo by photo.
    Eigen::VectorXd residuals(const Eigen::VectorXd& x) const
    {
        Eigen::Index count = 0;
        for (const View& view : _views)
            count += 2 * static_cast<Eigen::Index>(view.printed.size() + view.shown.size());
        Eigen::VectorXd all(count);
        Eigen::Index at = 0;
        const Eigen::Isometry3d toWorld = picture(x);
        for (std::size_t k = 0; k < _views.size(); ++k)
        {
            const View& view = _views[k];
            const Eigen::Isometry3d camera =
                view.start * motionOf(x.segment<6>(6 + 6 * static_cast<Eigen::Index>(k)));
            const auto add = [&](const Eigen::Isometry3d& pose, const SeenPlace& one)
            {
                all.segment<2>(at) = _rig.camera.project(pose * one.place) - one.pixel;
                at += 2;
            };
            for (const SeenPlace& one : view.printed)
                add(camera, one);
            for (const SeenPlace& one : view.shown)
                add(camera * toWorld, one);
        }
        return all;
    }

    /// Rms error of each photo's corners, pixels.
    Eigen::VectorXd rmsOfPhotos(const Eigen::VectorXd& residuals) const
    {
        Eigen::VectorXd rms(static_cast<Eigen::Index>(_views.size()));
        Eigen::Index at = 0;
        for (std::size_t k = 0; k < _views.size(); ++k)
        {
            const auto size =
                2 * static_cast<Eigen::Index>(_views[k].printed.size() + _views[k].shown.size());
            rms[static_cast<Eigen::Index>(k)] = std::sqrt(
                residuals.segment(at, size).squaredNorm() / (0.5 * static_cast<double>(size)));
            at += size;
        }
        return rms;
    }

private:
    /// Content of a photo: corners of printed tags in the world, of shown ones in the picture.
    struct View
    {
        Eigen::Isometry3d start; ///< world to camera
        std::vector<SeenPlace> printed, shown;
    };

    bool take(const TagPhoto& photo)
    {
        View view;
        for (const TagSeen& one : photo.seen)
        {
            const PlacedTag* const tag = _rig.find(one.id);
            const auto shown =
                std::find_if(_shown.begin(),
                             _shown.end(),
                             [&](const ShownTag& other) { return other.id == one.id; });
            for (int k = 0; k < 4; ++k)
            {
                const auto index = static_cast<std::size_t>(k);
                if (tag) view.printed.push_back({tag->corner(k), one.corners[index]});
                if (!tag && shown != _shown.end())
                    view.shown.push_back(
                        {inPicture(_display, shown->corners[index]), one.corners[index]});
            }
        }
        const std::size_t tags = (view.printed.size() + view.shown.size()) / 4;
        const auto camera = cameraPose(_rig, photo.seen);
        if (tags < kFewestTags || view.printed.empty() || view.shown.empty() || !camera)
            return false;
        view.start = *camera;
        const auto picture = planePose(_rig.camera, view.shown);
        if (!picture) return false;
        if (view.shown.size() > _mostShown)
        {
            _mostShown = view.shown.size();
            _start = view.start.inverse() * *picture;
        }
        _views.push_back(std::move(view));
        return true;
    }

    const Display& _display;
    const TagRig& _rig;
    std::vector<ShownTag> _shown;
    std::vector<View> _views;
    std::vector<int> _numbers;
    std::optional<Eigen::Isometry3d> _start; ///< of the picture
    std::size_t _mostShown = 0;
};

/// Returns the problem of \a photos before any fit; empty: none.
std::string wrongPhotos(const std::vector<TagPhoto>& photos,
                        const TagFitProblem& problem,
                        const Display& display,
                        const TagRig& rig)
{
    int mirrored = 0, shown = 0;
    const std::vector<ShownTag> ofScreen = shownTags(display);
    for (const TagPhoto& photo : photos)
    {
        mirrored += photo.mirrored;
        for (const TagSeen& tag : photo.seen)
            shown += !rig.find(tag.id) && tag.id >= ofScreen.front().id ? 1 : 0;
    }
    if (mirrored > shown)
        return fmt::format(
            "the tags on the screen are seen mirrored: by the file its light meets {} half "
            "mirrors, which is one too many or too few",
            std::count_if(display.optics.begin(),
                          display.optics.end(),
                          [](const Optic& optic)
                          { return optic.kind == Optic::Kind::HALF_MIRROR; }));
    if (problem.photos() < kFewestPhotos)
        return fmt::format("{} of {} photos show four tags, at least one on the array and one on "
                           "the screen; take at least three such photos",
                           problem.photos(),
                           photos.size());
    return {};
}

/// The fitted poses with their accuracy.
struct SolvedTags
{
    LeastSquares found;
    Eigen::Index freedom = 0;
    double noise_px = 0.0;
};

// Hidden corners have large errors: they are excluded, like outliers of touches.
SolvedTags solveTags(const TagFitProblem& problem)
{
    SolvedTags solved;
    Eigen::VectorXd start = Eigen::VectorXd::Zero(problem.unknowns());
    Eigen::VectorXd weights = Eigen::VectorXd::Ones(problem.residuals(start).size());
    for (int round = 0; round < 3; ++round)
    {
        solved.found =
            leastSquares([&](const Eigen::VectorXd& x)
                         { return Eigen::VectorXd(weights.cwiseProduct(problem.residuals(x))); },
                         start);
        start = solved.found.x;
        solved.freedom = static_cast<Eigen::Index>(weights.sum()) - problem.unknowns();
        solved.noise_px = std::sqrt(solved.found.residuals.squaredNorm() /
                                    static_cast<double>(std::max<Eigen::Index>(1, solved.freedom)));
        const Eigen::VectorXd all = problem.residuals(start);
        std::vector<double> sorted(all.data(), all.data() + all.size());
        for (double& value : sorted)
            value = std::abs(value);
        std::sort(sorted.begin(), sorted.end());
        // The median magnitude of a normal distribution is 0.674 sigma.
        const double limit_px =
            std::max(kLeastOutlier_px, kTagOutlierSigmas * sorted[sorted.size() / 2] / 0.674);
        for (Eigen::Index i = 0; i < all.size(); i += 2)
            weights.segment<2>(i).setConstant(
                all.segment<2>(i).cwiseAbs().maxCoeff() <= limit_px ? 1.0 : 0.0);
    }
    return solved;
}

} // namespace

std::vector<ShownTag> shownTags(const Display& display)
{
    std::vector<ShownTag> tags;
    const bool isFlipped = Picture(display).isFlipped();
    const auto count = static_cast<int>(displayCrosses().size());
    const double aspect = (display.lowerRight - display.lowerLeft).norm() /
                          (display.upperLeft - display.lowerLeft).norm();
    const double half_v = 0.5 * kTagShare;
    const double half_u = half_v / aspect * (isFlipped ? -1.0 : 1.0);
    for (int k = 0; k < count; ++k)
    {
        const Eigen::Vector2d at = displayCrosses()[static_cast<std::size_t>(k)];
        tags.push_back({TagDetector::kTags - count + k,
                        {at + Eigen::Vector2d(-half_u, -half_v),
                         at + Eigen::Vector2d(half_u, -half_v),
                         at + Eigen::Vector2d(half_u, half_v),
                         at + Eigen::Vector2d(-half_u, half_v)}});
    }
    return tags;
}

TagPhoto takePhoto(TagDetector& detector, const GrayImage& image, const Display& display)
{
    TagPhoto photo;
    photo.seen = detector.detect(image);
    const int first = shownTags(display).front().id;
    for (const TagSeen& tag : detector.detect(mirroredImage(image)))
        photo.mirrored += tag.id >= first ? 1 : 0;
    return photo;
}

DisplayFit fitTags(const Display& display,
                   const TagRig& rig,
                   const std::vector<TagPhoto>& photos,
                   const DisplayFitOptions& options)
{
    DisplayFit fit;
    fit.display = display;
    fit.method = "photos";
    fit.areInPixels = true;
    fit.edge_m = options.edge_m;
    const TagFitProblem problem(display, rig, photos);
    for (const int number : problem.numbers())
        fit.names.push_back(fmt::format("photo {}", number));
    fit.outlier.assign(fit.names.size(), false);
    fit.residuals = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(fit.names.size()));
    const std::string wrong = wrongPhotos(photos, problem, display, rig);
    if (!wrong.empty())
    {
        fit.problems.push_back(wrong);
        return fit;
    }
    const SolvedTags solved = solveTags(problem);
    const LeastSquares& found = solved.found;
    fit.noise = solved.noise_px;
    fit.residuals = problem.rmsOfPhotos(found.residuals);
    if (photos.size() > problem.photos())
        fit.notes.push_back(fmt::format(
            "{} of {} photos show too few tags", photos.size() - problem.photos(), photos.size()));
    if (!found.isDetermined)
        fit.problems.emplace_back("the photos don't determine the picture's position");
    else
        concludeFit(fit,
                    problem.picture(found.x),
                    found.covariance.topLeftCorner<6, 6>(),
                    static_cast<int>(solved.freedom),
                    options);
    if (fit.noise > kMostNoise_px)
        fit.problems.push_back(
            fmt::format("corners are off by {:.1f} pixels, at most {} are allowed: check the tags' "
                        "positions in the file, and the camera's numbers",
                        fit.noise,
                        kMostNoise_px));
    fit.usable = fit.problems.empty();
    return fit;
}

} // namespace midair::bridge

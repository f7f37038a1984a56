#include "engine-bridge/tags/TagRig.h"

#include "engine-bridge/calibration/LeastSquares.h"
#include "haptics/base/InputError.h"
#include "haptics/base/RegularFile.h"
#include "haptics/base/text/JsonValue.h"
#include "haptics/base/text/Words.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

namespace midair::bridge
{

namespace
{

using base::JsonValue;
using Eigen::Vector3d;

constexpr std::size_t kMostRig_bytes = std::size_t(1) << 20U;
constexpr double kFarthestTag_m = 100.0;
constexpr const char* kTagPlace = "a place [x, y, z] in metres, each within 100";

CameraModel cameraOf(const JsonValue& value, TagRig& rig, const std::string& source)
{
    value.object(
        {"device", "images", "pixels", "focal_px", "centre_px", "distortion", "eyes_m", "about"});
    CameraModel camera;
    const char* const right = "[width, height], whole numbers, 16 .. 16384";
    const JsonValue pixels = value.required("pixels", right);
    if (!pixels.isList() || pixels.size() != 2) pixels.wrong(right);
    camera.width = pixels[0].integer(16, 16384, right);
    camera.height = pixels[1].integer(16, 16384, right);
    const JsonValue focal = value.required("focal_px", "[fx, fy], pixels");
    const Eigen::VectorXd f = focal.vector(2, 1e6, "[fx, fy], pixels");
    if (!(f.minCoeff() > 0.0)) focal.wrong("[fx, fy], pixels, each above 0");
    camera.fx = f[0];
    camera.fy = f[1];
    camera.cx = 0.5 * camera.width;
    camera.cy = 0.5 * camera.height;
    if (const auto centre = value.find("centre_px"))
    {
        const Eigen::VectorXd c = centre->vector(2, 16384.0, "[cx, cy], pixels");
        camera.cx = c[0];
        camera.cy = c[1];
    }
    if (const auto distortion = value.find("distortion"))
    {
        const Eigen::VectorXd k = distortion->vector(2, 10.0, "[k1, k2], each within 10");
        camera.k1 = k[0];
        camera.k2 = k[1];
    }
    if (const auto eyes = value.find("eyes_m"))
        rig.eyes = eyes->vector(3, 1.0, "[x, y, z] in metres, each within 1");
    if (const auto device = value.find("device")) rig.device = device->string();
    if (const auto images = value.find("images"))
    {
        images->list("a list of PGM files", 10000);
        const std::filesystem::path folder = std::filesystem::path(source).parent_path();
        for (std::size_t i = 0; i < images->size(); ++i)
            rig.images.push_back((folder / (*images)[i].string()).string());
    }
    return camera;
}

PlacedTag tagOf(const JsonValue& value)
{
    value.object({"id", "size_m", "middle_m", "right", "up"});
    PlacedTag tag;
    tag.id = value.integer("id", 0, TagDetector::kTags - 1, "0 .. 586, of tag36h11");
    tag.size_m = value.number("size_m", 0.001, 2.0, "0.001 .. 2 m, the black square's edge");
    tag.middle = value.required("middle_m", kTagPlace).vector(3, kFarthestTag_m, kTagPlace);
    tag.right = value.required("right", "a direction [x, y, z]").direction();
    const JsonValue up = value.required("up", "a direction [x, y, z]");
    tag.up = up.direction();
    if (std::abs(tag.up.dot(tag.right)) > 0.02) up.wrong("a direction at right angles to right");
    tag.up = (tag.up - tag.up.dot(tag.right) * tag.right).normalized();
    return tag;
}

/// Rms reprojection error of \a places for the camera at \a pose.
Eigen::VectorXd missesOf(const CameraModel& camera,
                         const Eigen::Isometry3d& pose,
                         const std::vector<SeenPlace>& places)
{
    Eigen::VectorXd misses(2 * static_cast<Eigen::Index>(places.size()));
    for (std::size_t i = 0; i < places.size(); ++i)
        misses.segment<2>(2 * static_cast<Eigen::Index>(i)) =
            camera.project(pose * places[i].place) - places[i].pixel;
    return misses;
}

} // namespace

Eigen::Vector2d CameraModel::project(const Eigen::Vector3d& place) const
{
    // Points behind the camera are projected far away, so that no fit ends there.
    const double z = std::max(place.z(), 1e-3);
    const double x = place.x() / z;
    const double y = place.y() / z;
    const double r2 = x * x + y * y;
    const double factor = 1.0 + r2 * (k1 + r2 * k2);
    return {fx * factor * x + cx, fy * factor * y + cy};
}

Eigen::Vector2d CameraModel::ray(const Eigen::Vector2d& pixel) const
{
    const Eigen::Vector2d seen((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
    Eigen::Vector2d straight = seen;
    for (int round = 0; round < 20; ++round)
    {
        const double r2 = straight.squaredNorm();
        straight = seen / (1.0 + r2 * (k1 + r2 * k2));
    }
    return straight;
}

Eigen::Vector3d PlacedTag::corner(int k) const
{
    const double x = k == 1 || k == 2 ? 0.5 : -0.5;
    const double y = k >= 2 ? 0.5 : -0.5;
    return middle + size_m * (x * right + y * up);
}

const PlacedTag* TagRig::find(int id) const
{
    const auto found =
        std::find_if(tags.begin(), tags.end(), [&](const PlacedTag& tag) { return tag.id == id; });
    return found == tags.end() ? nullptr : &*found;
}

TagRig readTagRig(const std::string& text, const std::string& source)
{
    const JsonValue::Json file = base::parseJson(text, source);
    const JsonValue root(source, file);
    root.object({"about", "camera", "tags"});
    TagRig rig;
    rig.camera =
        cameraOf(root.required("camera", "an object with pixels and focal_px"), rig, source);
    const JsonValue tags = root.required("tags", "a list of printed tags");
    tags.list("a list of printed tags", TagDetector::kTags);
    for (std::size_t i = 0; i < tags.size(); ++i)
    {
        const PlacedTag tag = tagOf(tags[i]);
        if (rig.find(tag.id)) tags[i].fail(fmt::format("is tag {} once more", tag.id));
        rig.tags.push_back(tag);
    }
    if (rig.tags.empty()) tags.wrong("a list of at least one tag");
    return rig;
}

TagRig loadTagRig(const std::string& path)
{
    const std::string name = base::printable(path);
    return readTagRig(base::readRegularFile(path, kMostRig_bytes, "tag file \"" + name + "\" "),
                      path);
}

std::optional<Eigen::Isometry3d> planePose(const CameraModel& camera,
                                           const std::vector<SeenPlace>& places)
{
    // Each place gives two linear equations for the homography H, whose last number is 1.
    Eigen::Matrix<double, 8, 8> normal = Eigen::Matrix<double, 8, 8>::Zero();
    Eigen::Matrix<double, 8, 1> right = Eigen::Matrix<double, 8, 1>::Zero();
    for (const SeenPlace& one : places)
    {
        const Eigen::Vector2d to = camera.ray(one.pixel);
        const double x = one.place.x(), y = one.place.y();
        Eigen::Matrix<double, 2, 8> rows;
        rows << x, y, 1.0, 0.0, 0.0, 0.0, -to.x() * x, -to.x() * y, //
            0.0, 0.0, 0.0, x, y, 1.0, -to.y() * x, -to.y() * y;
        normal += rows.transpose() * rows;
        right += rows.transpose() * to;
    }
    const Eigen::Matrix<double, 8, 1> h = normal.ldlt().solve(right);
    if (places.size() < 4 || !h.allFinite()) return {};
    const Vector3d first(h[0], h[3], h[6]);
    const Vector3d second(h[1], h[4], h[7]);
    const double scale = 0.5 * (first.norm() + second.norm());
    if (!(scale > 1e-9)) return {};
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    const Vector3d x = first.normalized();
    const Vector3d y = (second - x.dot(second) * x).normalized();
    pose.linear() << x, y, x.cross(y);
    pose.translation() = Vector3d(h[2], h[5], 1.0) / scale;
    if (!pose.matrix().allFinite()) return {};
    return pose;
}

std::optional<Eigen::Isometry3d>
cameraPose(const TagRig& rig, const std::vector<TagSeen>& seen, double most_px)
{
    std::vector<SeenPlace> all;
    std::vector<Eigen::Isometry3d> starts;
    for (const TagSeen& one : seen)
    {
        const PlacedTag* const tag = rig.find(one.id);
        if (!tag) continue;
        std::vector<SeenPlace> flat;
        const double half = 0.5 * tag->size_m;
        const Vector3d corners[] = {
            {-half, -half, 0.0}, {half, -half, 0.0}, {half, half, 0.0}, {-half, half, 0.0}};
        for (int k = 0; k < 4; ++k)
        {
            const Eigen::Vector2d& pixel = one.corners[static_cast<std::size_t>(k)];
            all.push_back({tag->corner(k), pixel});
            flat.push_back({corners[k], pixel});
        }
        const auto toCamera = planePose(rig.camera, flat);
        if (!toCamera) continue;
        Eigen::Isometry3d place = Eigen::Isometry3d::Identity();
        place.linear() << tag->right, tag->up, tag->right.cross(tag->up);
        place.translation() = tag->middle;
        starts.push_back(*toCamera * place.inverse());
    }
    std::optional<Eigen::Isometry3d> best;
    double least = most_px * most_px * static_cast<double>(all.size());
    for (const Eigen::Isometry3d& start : starts)
    {
        const LeastSquares found =
            leastSquares([&](const Eigen::VectorXd& x)
                         { return missesOf(rig.camera, start * motionOf(x), all); },
                         Eigen::VectorXd::Zero(6));
        if (!(found.residuals.squaredNorm() < least)) continue;
        least = found.residuals.squaredNorm();
        best = start * motionOf(found.x);
    }
    return best;
}

Eigen::Isometry3d headOf(const TagRig& rig, const Eigen::Isometry3d& worldToCamera)
{
    Eigen::Isometry3d head = worldToCamera.inverse();
    head.linear().col(1) *= -1.0;
    head.linear().col(2) *= -1.0;
    head.translation() = head * rig.eyes;
    return head;
}

} // namespace midair::bridge

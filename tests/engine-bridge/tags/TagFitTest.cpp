#include "engine-bridge/tags/TagFit.h"

#include "tests/engine-bridge/display/CrossSimulation.h"
#include "tests/engine-bridge/tags/TagSimulation.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace
{

using namespace midair::bridge;
using Eigen::Vector3d;

std::vector<TagPhoto> photos(TagSimulation& simulation, const Display& file, int count)
{
    TagDetector detector;
    std::vector<TagPhoto> all;
    for (int k = 0; k < count; ++k)
        all.push_back(takePhoto(detector, simulation.photo(simulation.camera(0.12)), file));
    return all;
}

} // namespace

// A prototype had 0.3 mm, at most 0.5 mm.
TEST(TagFit, FindsTheScreenThroughAMirrorToThreeTenthsOfAMillimetre)
{
    const Display truth = displays::halfMirror();
    const Display file = guessedDisplay(truth);
    const Vector3d middle = CrossSimulation(truth, 1).middle();
    std::vector<double> errors;
    for (std::uint64_t seed = 1; seed <= 5; ++seed)
    {
        TagSimulation simulation(truth, TagSimulation::rig(), shownTags(file), seed);
        const DisplayFit fit = fitTags(file, TagSimulation::rig(), photos(simulation, file, 9));
        ASSERT_TRUE(fit.usable) << fit.text();
        errors.push_back((fit.middle() - middle).norm());
        RecordProperty("error_um_" + std::to_string(seed), static_cast<int>(1e6 * errors.back()));
        EXPECT_LT((fit.display.lowerLeft - truth.lowerLeft).norm(), 2e-3);
    }
    std::sort(errors.begin(), errors.end());
    EXPECT_LT(errors[2], 1.2 * 0.3e-3);
    EXPECT_LT(errors[4], 1.2 * 0.5e-3);
}

TEST(TagFit, RefusesTagsThatAreSeenMirroredAndPhotosThatShowTooLittle)
{
    const Display truth = displays::halfMirror();
    Display plain = truth; // by the file no mirror turns the picture over
    plain.optics.clear();
    TagSimulation simulation(truth, TagSimulation::rig(), shownTags(plain), 1);
    const DisplayFit mirrored = fitTags(plain, TagSimulation::rig(), photos(simulation, plain, 3));
    EXPECT_FALSE(mirrored.usable);
    EXPECT_NE(mirrored.text().find("not usable: the tags on the screen are seen mirrored: by the "
                                   "file its light meets 0 half mirrors, which is one too many or "
                                   "too few\n"),
              std::string::npos)
        << mirrored.text();

    TagSimulation dark(truth, TagSimulation::rig(), {}, 1);
    const DisplayFit few = fitTags(truth, TagSimulation::rig(), photos(dark, truth, 1));
    EXPECT_FALSE(few.usable);
    EXPECT_NE(few.text().find("not usable: 0 of 1 photos show four tags"), std::string::npos)
        << few.text();
}

TEST(TagRig, FindsTheCameraByPrintedTags)
{
    TagSimulation simulation(displays::window(), TagSimulation::rig(), {}, 4);
    TagDetector detector;
    for (int k = 0; k < 3; ++k)
    {
        const Eigen::Isometry3d truth = simulation.camera(0.15);
        const auto pose =
            cameraPose(TagSimulation::rig(), detector.detect(simulation.photo(truth)));
        ASSERT_TRUE(pose);
        EXPECT_LT((pose->inverse().translation() - truth.inverse().translation()).norm(), 2e-3);
        EXPECT_LT(Eigen::AngleAxisd((pose->inverse() * truth).linear()).angle(), 4e-3);
    }
}

TEST(TagRig, ReadsItsFileAndRefusesWhatIsNone)
{
    const std::string text = R"({"camera": {"images": ["a.pgm"], "pixels": [640, 480],
        "focal_px": [500, 510], "distortion": [0.1, -0.02], "eyes_m": [0, -0.05, 0.03]},
        "tags": [{"id": 7, "size_m": 0.05, "middle_m": [1, 2, 3], "right": [0, 2, 0],
                  "up": [0, 0, 1]}]})";
    const TagRig rig = readTagRig(text, "folder/rig.json");
    EXPECT_EQ(rig.images.front(), "folder/a.pgm");
    EXPECT_EQ(rig.camera.cx, 320.0);
    EXPECT_TRUE(rig.tags[0].corner(0).isApprox(Vector3d(1.0, 1.975, 2.975)));
    EXPECT_TRUE(rig.tags[0].corner(2).isApprox(Vector3d(1.0, 2.025, 3.025)));
    // What is seen at a pixel is projected to it.
    const Eigen::Vector2d pixel(600.0, 100.0);
    const Eigen::Vector2d ray = rig.camera.ray(pixel);
    EXPECT_LT((rig.camera.project({2.0 * ray.x(), 2.0 * ray.y(), 2.0}) - pixel).norm(), 1e-6);

    const auto errorOf = [&](const std::string& from, const std::string& to)
    {
        std::string changed = text;
        changed.replace(changed.find(from), from.size(), to);
        try
        {
            readTagRig(changed, "r");
        }
        catch (const std::exception& error)
        {
            return std::string(error.what());
        }
        return std::string();
    };
    EXPECT_NE(errorOf("[0, 0, 1]", "[0, 1, 1]").find("a direction at right angles to right"),
              std::string::npos);
    EXPECT_NE(errorOf("\"id\": 7", "\"id\": 600").find("0 .. 586"), std::string::npos);
    EXPECT_NE(errorOf("[500, 510]", "[0, 510]").find("[fx, fy], pixels, each above 0"),
              std::string::npos);
}

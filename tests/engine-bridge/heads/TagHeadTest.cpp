#include "engine-bridge/heads/TagHead.h"

#include "engine-bridge/heads/HeadOpening.h"
#include "tests/Eventually.h"
#include "tests/engine-bridge/tags/TagSimulation.h"

#include <fstream>
#include <string>

#include <gtest/gtest.h>

namespace
{

using namespace midair::bridge;

/// Writes a rig whose camera is the file \a image, and returns its name.
std::string rigFile(const std::string& image)
{
    const std::string path = testing::TempDir() + "midair-rig.json";
    std::ofstream out(path);
    out << R"({"camera": {"images": [")" << image
        << R"("], "pixels": [1280, 960], "focal_px": [1000, 1000], "eyes_m": [0, -0.05, 0]},
        "tags": [)";
    const TagRig rig = TagSimulation::rig();
    for (const PlacedTag& tag : rig.tags)
        out << (tag.id > 0 ? "," : "") << R"({"id": )" << tag.id
            << R"(, "size_m": 0.06, "middle_m": [)" << tag.middle.x() << "," << tag.middle.y()
            << "," << tag.middle.z() << R"(], "right": [1, 0, 0], "up": [0, 0.5, 0.866]})";
    out << "]}";
    return path;
}

} // namespace

TEST(TagHead, IsWhereTheCameraSeesTheTagsFrom)
{
    TagSimulation simulation(displays::window(), TagSimulation::rig(), {}, 2);
    const Eigen::Isometry3d camera = simulation.camera(0.1);
    const GrayImage image = simulation.photo(camera);
    {
        std::ofstream out(testing::TempDir() + "midair-tags.pgm", std::ios::binary);
        out << "P5\n# a photo\n1280 960\n255\n";
        out.write(reinterpret_cast<const char*>(image.pixels.data()),
                  static_cast<std::streamsize>(image.pixels.size()));
    }
    const auto source = openHead("tag:" + rigFile("midair-tags.pgm"));
    Head head;
    // On a busy machine an image may be stale before it is looked through.
    ASSERT_TRUE(eventually(
        [&]
        {
            source->headAt(3.0, head);
            return !head.pose.isApprox(Eigen::Isometry3d::Identity());
        }))
        << source->status();
    EXPECT_EQ(head.time_s, 3.0);
    EXPECT_GE(head.age_s, 0.0);
    // The eyes are 5 cm below the camera: along its image's y.
    const Eigen::Vector3d eyes = camera.inverse() * Eigen::Vector3d(0.0, 0.05, 0.0);
    EXPECT_LT((head.pose.translation() - eyes).norm(), 2e-3);
    // It looks along -z as the camera does along z.
    EXPECT_GT(-head.pose.linear().col(2).dot(camera.inverse().linear().col(2)), 0.9999);
    EXPECT_EQ(source->status().find("camera images, "), 0U) << source->status();
}

TEST(TagHead, SaysWhatIsMissing)
{
    const auto errorOf = [](const std::string& text)
    {
        try
        {
            openHead(text);
        }
        catch (const std::exception& error)
        {
            return std::string(error.what());
        }
        return std::string();
    };
    EXPECT_EQ(errorOf("tag:"),
              "head source \"tag:\": should be tag:FILE, where FILE describes camera and tags");
    EXPECT_NE(errorOf("tag:/nowhere.json").find("can't be read"), std::string::npos);
    const auto source = openHead("tag:" + rigFile("nowhere.pgm"));
    std::vector<std::string> told;
    ASSERT_TRUE(eventually(
        [&]
        {
            told = source->takeMessages();
            return !told.empty();
        }));
    EXPECT_EQ(told.front().find("the camera failed: "), 0U) << told.front();
}

// glTF models by their files' names: as MODEL.haptic, in OSG's own programs, and what they name.
#include "tests/plugin/KitTest.h"
#include "tests/plugin/gltf/GltfModel.h"
#include "tests/plugin/loader/StockPrograms.h"

#include <osg/ComputeBoundsVisitor>
#include <osgDB/FileUtils>
#include <osgDB/ReadFile>
#include <osgDB/Registry>

#include <filesystem>

#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

/// Two triangles of 20 mm at (0 0 150 mm) of OSG and 10 mm beside it; nodes "left" and "right".
GltfModel twoPlates()
{
    GltfModel model = GltfModel::triangle();
    model.json["nodes"] = {{{"name", "left"},
                            {"mesh", 0},
                            {"translation", {-0.03, 0.15, 0}},
                            {"scale", {0.02, 0.01, 1}}},
                           {{"name", "right"},
                            {"mesh", 0},
                            {"translation", {0.01, 0.15, 0}},
                            {"scale", {0.02, 0.01, 1}}}};
    model.json["scenes"][0]["nodes"] = {0, 1};
    return model;
}

class GltfLoader : public testing::Test
{
protected:
    void SetUp() override { findPlugins(); }

    osg::ref_ptr<HapticScene> read(const std::string& name, const std::string& options = {})
    {
        const osg::ref_ptr<osgDB::Options> given = new osgDB::Options("array=board " + options);
        const osg::ref_ptr<osg::Node> node =
            osgDB::readRefNodeFile((folder.path / name).string() + ".haptic", given);
        return dynamic_cast<HapticScene*>(node.get());
    }

    const TemporaryFolder folder;
};

double farthestLeft(const HapticScene& scene)
{
    return SceneAccess::latestResult(scene)->points.positions.row(0).minCoeff();
}

} // namespace

TEST_F(GltfLoader, AllIsFeltWhereNothingIsTagged)
{
    folder.write("plates.glb", twoPlates().glb());
    const osg::ref_ptr<HapticScene> scene = read("plates.glb", "pressure=500 Pa");
    ASSERT_TRUE(scene);
    HeadlessViewer viewer(scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return SceneAccess::latestResult(*scene) != nullptr; }));
    EXPECT_LT(farthestLeft(*scene), 0.0);
    EXPECT_EQ(dynamic_cast<HapticSurface*>(scene->getChild(0))->getPressure(), 500.0);
}

TEST_F(GltfLoader, WhatIsTaggedAloneIsFelt)
{
    GltfModel model = twoPlates();
    model.json["nodes"][1]["extras"] = {{"haptic", true}, {"pressure", "800 Pa"}};
    folder.write("plates.gltf", model.gltf());
    Notices notices;
    const osg::ref_ptr<HapticScene> scene = read("plates.gltf", "pressure=500 Pa");
    ASSERT_TRUE(scene);
    EXPECT_NE(notices.text().find("haptic options are ignored"), std::string::npos)
        << notices.text();
    HeadlessViewer viewer(scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return SceneAccess::latestResult(*scene) != nullptr; }));
    EXPECT_GT(farthestLeft(*scene), 0.0);
    EXPECT_NEAR(SceneAccess::latestResult(*scene)->points.targets.maxCoeff(), 800.0, 1.0);
}

TEST_F(GltfLoader, ATagThatIsUnclearSilences)
{
    GltfModel model = twoPlates();
    model.json["nodes"][1]["extras"] = {{"haptic", true}, {"presure", "800 Pa"}};
    folder.write("plates.gltf", model.gltf());
    const osg::ref_ptr<HapticScene> scene = read("plates.gltf");
    ASSERT_TRUE(scene);
    HeadlessViewer viewer(scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return !scene->getStatistics().messages.empty(); }));
    EXPECT_TRUE(
        viewer.framesUntil([&] { return scene->getStatistics().state == ArrayState::SILENT; }));
    const std::string said = scene->getStatistics().messages[0];
    EXPECT_NE(said.find("unknown option \"presure\" (did you mean pressure?)"), std::string::npos)
        << said;
}

TEST_F(GltfLoader, AMeshsPressureIsPlayed)
{
    GltfModel model = twoPlates();
    model.json["meshes"][0]["extras"] = {{"haptic", true}, {"pressure", "600 Pa"}};
    folder.write("plates.gltf", model.gltf());
    const osg::ref_ptr<HapticScene> scene = read("plates.gltf");
    ASSERT_TRUE(scene);
    HeadlessViewer viewer(scene);
    ASSERT_TRUE(viewer.framesUntil([&] { return SceneAccess::latestResult(*scene) != nullptr; }));
    EXPECT_NEAR(SceneAccess::latestResult(*scene)->points.targets.maxCoeff(), 600.0, 1.0);
}

// The whole of such a model would be felt as loud as it can be.
TEST_F(GltfLoader, APressureThatIsNotFollowedSilencesTheWhole)
{
    for (const char* place :
         {"/meshes/0/extras", "/nodes/1/extras", "/meshes/0/primitives/0/extras"})
    {
        GltfModel model = twoPlates();
        model.json[GltfModel::Json::json_pointer(place)] = {{"pressure", "600 Pa"}};
        folder.write("plates.gltf", model.gltf());
        const osg::ref_ptr<HapticScene> scene = read("plates.gltf");
        ASSERT_TRUE(scene);
        EXPECT_TRUE(scene->getSettings().isSilenced) << place;
        ASSERT_FALSE(scene->getSettings().whySilenced.empty()) << place;
        EXPECT_NE(scene->getSettings().whySilenced[0].find("has the extra \"pressure\""),
                  std::string::npos);
    }
}

TEST_F(GltfLoader, ASceneSaysWhatAHapticSceneMay)
{
    GltfModel model = twoPlates();
    auto& extras = model.json["scenes"][0]["extras"];
    extras = {{"maxPressure", "700 Pa"}, {"device", "usb:"}};
    folder.write("plates.gltf", model.gltf());
    osg::ref_ptr<HapticScene> scene = read("plates.gltf");
    ASSERT_TRUE(scene);
    EXPECT_EQ(scene->getSettings().maxPressure, 700.0);
    EXPECT_EQ(scene->getSettings().wishes.asked.at("device"), "usb:"); // the user has to grant it
    EXPECT_FALSE(scene->getSettings().isSilenced);
    extras = {{"maxPresure", "700 Pa"}};
    folder.write("plates.gltf", model.gltf());
    scene = read("plates.gltf");
    ASSERT_TRUE(scene);
    EXPECT_TRUE(scene->getSettings().isSilenced);
}

TEST_F(GltfLoader, FilesBesideItAreReadAndOthersAreNot)
{
    GltfModel model = twoPlates();
    std::filesystem::create_directory(folder.path / "model");
    folder.write("model/plates.bin", model.buffer);
    folder.write("outside.bin", model.buffer);
    std::filesystem::create_symlink(folder.path / "outside.bin", folder.path / "model/link.bin");
    const auto said = [&](const std::string& uri)
    {
        model.json["buffers"] = {{{"byteLength", model.buffer.size()}, {"uri", uri}}};
        folder.write("model/plates.gltf", model.json.dump());
        Notices notices;
        const osg::ref_ptr<osg::Node> node = read("model/plates.gltf");
        return (node ? "read" : "") + notices.text();
    };
    EXPECT_EQ(said("plates.bin"), "read");
    for (const std::string& uri :
         {std::string("../outside.bin"), std::string("..%2Foutside.bin"), std::string("link.bin")})
        EXPECT_NE(said(uri).find(", outside of its folder; only files beside it are read"),
                  std::string::npos)
            << said(uri);
    EXPECT_NE(said("/dev/zero").find("can't be read: "), std::string::npos);
    EXPECT_NE(said("nothing.bin").find("can't be read: "), std::string::npos);
}

TEST_F(GltfLoader, OsgsProgramsReadItWhereNobodyElseDoes)
{
    if (!installed("osgconv")) GTEST_SKIP() << "osgconv is not installed";
    folder.write("plates.glb", twoPlates().glb());
    bool ok = false;
    const std::string model = (folder.path / "plates.glb").string();
    const std::string out = (folder.path / "plates.osgt").string();
    const std::string said = run(stock("osgconv") + " " + model + " " + out, ok);
    EXPECT_TRUE(ok && std::filesystem::exists(out)) << said;
    EXPECT_NE(contents(out).find("\"right\""), std::string::npos);
}

TEST_F(GltfLoader, AnotherPluginIsLeftToReadIt)
{
    if (!installed("osgconv")) GTEST_SKIP() << "osgconv is not installed";
    folder.write("plates.glb", twoPlates().glb());
    // OSG's reader of .obj under that name: it reads no .glb, but is loaded.
    osgDB::Registry& registry = *osgDB::Registry::instance();
    const std::string obj = osgDB::findLibraryFile(registry.createLibraryNameForExtension("obj"));
    ASSERT_FALSE(obj.empty());
    const auto other = folder.path / std::filesystem::path(obj).parent_path().filename();
    std::filesystem::create_directory(other);
    std::filesystem::copy_file(obj, other / "osgdb_glb.so");
    bool ok = false;
    const std::string out = (folder.path / "plates.osgt").string();
    const std::string path =
        "OSG_LIBRARY_PATH=" MIDAIR_LIBRARY_FOLDER ":" + folder.path.string() + " ";
    const std::string said = run("env OSG_NOTIFY_LEVEL=DEBUG " + path + stock("osgconv") + " " +
                                     (folder.path / "plates.glb").string() + " " + out,
                                 ok);
    EXPECT_NE(said.find((other / "osgdb_glb.so").string()), std::string::npos) << said;
}

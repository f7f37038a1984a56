// What is told when a scene is saved in a format that can't hold what makes it haptic.
#include "tests/plugin/KitTest.h"

#include <osg/ValueObject>
#include <osgDB/WriteFile>

#include <filesystem>

#include <gtest/gtest.h>
#include <unistd.h>

namespace
{

struct Saved
{
    explicit Saved(const osg::Node& node, const std::string& name)
    {
        findPlugins();
        const auto folder =
            std::filesystem::temp_directory_path() / ("midair-saving-" + std::to_string(getpid()));
        std::filesystem::create_directory(folder);
        Notices notices;
        ok = osgDB::writeNodeFile(node, (folder / name).string());
        exists = std::filesystem::exists(folder / name);
        told = notices.text();
        std::filesystem::remove_all(folder);
    }
    bool ok = false;
    bool exists = false;
    std::string told;
};

bool has(const std::string& text, const std::string& part)
{
    return text.find(part) != std::string::npos;
}

} // namespace

TEST(Saving, AKitSceneAsOsgIsRefused)
{
    const BoxScene box;
    const Saved saved(*box.scene, "scene.osg");
    EXPECT_FALSE(saved.ok);
    EXPECT_FALSE(saved.exists) << "no empty file";
    EXPECT_TRUE(has(saved.told, "scene.osg is not written: .osg can't hold HapticScene and 1 more"))
        << saved.told;
}

TEST(Saving, AKitSceneInAnotherFormatIsTold)
{
    const BoxScene box;
    const Saved saved(*box.scene, "scene.ive");
    EXPECT_TRUE(has(saved.told, "scene.ive: .ive doesn't keep HapticScene and 1 more"))
        << saved.told;
}

TEST(Saving, TagsThatAreLostAreTold)
{
    const osg::ref_ptr<osg::Group> root = new osg::Group;
    const osg::ref_ptr<osg::Group> mug = new osg::Group;
    mug->setName("mug");
    mug->setUserValue("haptic", std::string("pressure=500 Pa"));
    mug->addChild(BoxScene::box());
    root->addChild(mug);
    mug->setNodeMask(0);
    for (const char* name : {"tagged.ive", "tagged.osg"})
    {
        const Saved saved(*root, name);
        EXPECT_TRUE(saved.ok) << name;
        EXPECT_TRUE(has(saved.told, "keeps no user values; lost are the tags of Group 'mug'"))
            << saved.told;
    }
}

TEST(Saving, WhatKeepsAllSaysNothing)
{
    const BoxScene box;
    for (const char* name : {"scene.osgt", "scene.osgb", "scene.osgx"})
    {
        const Saved saved(*box.scene, name);
        EXPECT_TRUE(saved.ok && saved.exists) << name;
        EXPECT_EQ(saved.told, "") << name;
    }
    const osg::ref_ptr<osg::Group> plain = new osg::Group;
    plain->addChild(new osg::Group);
    EXPECT_EQ(Saved(*plain, "plain.ive").told, "");
}

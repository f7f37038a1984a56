// What is told when a scene is saved in a format that can't hold what makes it haptic.
#include "tests/plugin/KitTest.h"

#include <osgMidair/HapticPoints>

#include <osg/Geode>
#include <osg/Geometry>
#include <osg/ValueObject>
#include <osgDB/ReadFile>
#include <osgDB/WriteFile>

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

namespace
{

struct Saved
{
    Saved(const osg::Node& node, const std::string& name)
    {
        findPlugins();
        const auto folder =
            std::filesystem::temp_directory_path() / ("midair-saving-" + std::to_string(getpid()));
        std::filesystem::create_directory(folder);
        Notices notices;
        ok = osgDB::writeNodeFile(node, (folder / name).string());
        exists = std::filesystem::exists(folder / name);
        told = notices.text();
        if (exists) read = osgDB::readRefNodeFile((folder / name).string());
        std::filesystem::remove_all(folder);
    }
    bool ok = false;
    bool exists = false;
    std::string told;
    osg::ref_ptr<osg::Node> read; ///< what is in the file; null: nothing that OSG reads
};

/// Finds what makes a scene haptic, in each of its notations.
struct Notations : osg::NodeVisitor
{
    explicit Notations(osg::Node* node) : osg::NodeVisitor(TRAVERSE_ALL_CHILDREN)
    {
        if (node) node->accept(*this);
    }
    void apply(osg::Node& node) override
    {
        const std::string type = node.className();
        for (const char* ours : {"HapticScene", "HapticSurface", "HapticPoints"})
            if (type == ours) found.insert(ours);
        const osg::UserDataContainer* data = node.getUserDataContainer();
        for (const char* tag : {"haptic", "obstacle"})
        {
            if (data && data->getUserObject(tag)) found.insert(std::string("value ") + tag);
            for (const std::string& text :
                 data ? data->getDescriptions() : osg::UserDataContainer::DescriptionList())
                if (text.rfind(tag, 0) == 0) found.insert(std::string("description ") + tag);
        }
        traverse(node);
    }
    std::set<std::string> found;
};

/// A scene that is haptic in one notation.
osg::ref_ptr<osg::Group> markedBy(const std::string& notation)
{
    osg::ref_ptr<osg::Group> mark = new osg::MatrixTransform;
    if (notation == "HapticScene") mark = new osgMidair::HapticScene;
    if (notation == "HapticSurface") mark = new osgMidair::HapticSurface;
    if (notation == "HapticPoints") mark->addChild(new osgMidair::HapticPoints);
    const std::string tag = notation.substr(notation.find(' ') + 1);
    if (notation.rfind("value ", 0) == 0) mark->setUserValue(tag, true);
    if (notation.rfind("description ", 0) == 0) mark->addDescription(tag);
    const osg::ref_ptr<osg::Geode> geode = new osg::Geode;
    geode->addDrawable(osg::createTexturedQuadGeometry(
        osg::Vec3(), osg::Vec3(1.0f, 0.0f, 0.0f), osg::Vec3(0.0f, 1.0f, 0.0f)));
    mark->addChild(geode);
    const osg::ref_ptr<osg::Group> root = new osg::Group;
    root->addChild(mark);
    return root;
}

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

TEST(Saving, EachNotationIsKeptOrToldInEachFormat)
{
    const std::vector<std::string> notations = {"HapticScene",
                                                "HapticSurface",
                                                "HapticPoints",
                                                "value haptic",
                                                "value obstacle",
                                                "description haptic",
                                                "description obstacle"};
    std::map<std::string, std::string> kept; // by format: + kept, - told, in that order
    for (const char* format :
         {"osgt", "osgb", "osgx", "osgt.gz", "ive", "ivez", "osg", "osg.gz", "obj", "stl"})
        for (const std::string& notation : notations)
        {
            const Saved saved(*markedBy(notation), std::string("scene.") + format);
            const bool isKept = Notations(saved.read).found.count(notation) > 0;
            const bool isTold = has(saved.told, "osgMidair: ") && has(saved.told, "keep all");
            EXPECT_NE(isKept, isTold) << format << ", " << notation << ": " << saved.told;
            kept[format] += isKept ? "+" : "-";
        }
    const std::map<std::string, std::string> wanted = {{"osgt", "+++++++"},
                                                       {"osgb", "+++++++"},
                                                       {"osgx", "+++++++"},
                                                       {"osgt.gz", "+++++++"},
                                                       {"ive", "-----++"},
                                                       {"ivez", "-----++"},
                                                       {"osg", "-----++"},
                                                       {"osg.gz", "-----++"},
                                                       {"obj", "-------"},
                                                       {"stl", "-------"}};
    EXPECT_EQ(kept, wanted);
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

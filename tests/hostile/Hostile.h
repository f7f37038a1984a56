#pragma once

#include "plugin/engine/SceneAccess.h"
#include "tests/plugin/KitTest.h"

#include <osgDB/ReadFile>
#include <osgDB/WriteFile>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

/// A folder of its own with a scene in it and things beside it; gone with the object.
class Workplace
{
public:
    Workplace()
    {
        std::string name = (std::filesystem::temp_directory_path() / "osgmidair-XXXXXX").string();
        _root = std::filesystem::canonical(mkdtemp(name.data()));
        std::filesystem::create_directory(_root / "scene");
    }
    ~Workplace() { std::filesystem::remove_all(_root); }
    Workplace(const Workplace&) = delete;
    Workplace& operator=(const Workplace&) = delete;

    /// Outside the scene's folder.
    std::string outside(const std::string& name) const { return (_root / name).string(); }
    std::string beside(const std::string& name) const { return (_root / "scene" / name).string(); }

    static std::string write(const std::string& path, const std::string& text)
    {
        std::ofstream(path) << text;
        return path;
    }
    static std::string read(const std::string& path)
    {
        std::stringstream text;
        text << std::ifstream(path).rdbuf();
        return text.str();
    }

private:
    std::filesystem::path _root;
};

/// An environment variable as long as it lives.
class Variable
{
public:
    Variable(const char* name, const std::string& value) : _name(name)
    {
        const char* before = std::getenv(name);
        _was = before ? before : "";
        _had = before != nullptr;
        setenv(name, value.c_str(), 1);
    }
    ~Variable()
    {
        if (_had)
            setenv(_name.c_str(), _was.c_str(), 1);
        else
            unsetenv(_name.c_str());
    }
    Variable(const Variable&) = delete;
    Variable& operator=(const Variable&) = delete;

private:
    std::string _name;
    std::string _was;
    bool _had = false;
};

/// The options of a command line, -O, as long as it lives.
class CommandLine
{
public:
    explicit CommandLine(const std::string& options) :
        _before(osgDB::Registry::instance()->getOptions())
    {
        const osg::ref_ptr<osgDB::Options> given = new osgDB::Options(options);
        given->setObjectCacheHint(osgDB::Options::CACHE_NONE);
        osgDB::Registry::instance()->setOptions(given);
    }
    ~CommandLine() { osgDB::Registry::instance()->setOptions(_before); }
    CommandLine(const CommandLine&) = delete;
    CommandLine& operator=(const CommandLine&) = delete;

private:
    osg::ref_ptr<osgDB::Options> _before;
};

/// A scene of somebody else's that came as a file of the format under test: what it can do to the
/// user who looks at it.
class Hostile : public testing::TestWithParam<const char*>
{
protected:
    Hostile() : _grants("OSG_MIDAIR_GRANTS", _place.outside("grants"))
    {
        findPlugins();
        Workplace::write(_place.outside("grants"), "");
    }

    /// A box that can be felt, in a scene whose settings \a change has filled with its author's
    /// wishes; then through the file.
    osg::ref_ptr<osgMidair::HapticScene>
    fromFile(const std::function<void(osgMidair::HapticScene&)>& change,
             const std::string& options = {})
    {
        BoxScene box;
        box.scene->setName("evil");
        change(*box.scene);
        const std::string file = _place.beside(std::string("scene.") + GetParam());
        EXPECT_TRUE(osgDB::writeNodeFile(*box.scene, file));
        const CommandLine given(options);
        osg::ref_ptr<osg::Node> node = osgDB::readRefNodeFile(file);
        auto* scene = dynamic_cast<osgMidair::HapticScene*>(node.get());
        EXPECT_NE(scene, nullptr);
        return scene;
    }

    /// Looks at it until something is played, or refused.
    /// Nothing is played any more once the viewer is gone.
    static std::unique_ptr<HeadlessViewer> view(osgMidair::HapticScene& scene)
    {
        auto viewer = std::make_unique<HeadlessViewer>(&scene);
        EXPECT_TRUE(viewer->framesUntil(
            [&] { return osgMidair::SceneAccess::latestResult(scene) != nullptr; }));
        viewer->frames(20);
        return viewer;
    }

    /// Looks at it for a while, whatever it does.
    static void viewBriefly(osg::Node& scene)
    {
        HeadlessViewer viewer(&scene);
        viewer.framesFor(0.5);
    }

    static bool says(const osgMidair::HapticScene& scene, const std::string& words)
    {
        for (const std::string& message : scene.getStatistics().messages)
            if (message.find(words) != std::string::npos) return true;
        return false;
    }
    static std::string messages(const osgMidair::HapticScene& scene)
    {
        std::string all;
        for (const std::string& message : scene.getStatistics().messages)
            all += message + "\n";
        return all;
    }
    static bool simulates(const osgMidair::HapticScene& scene)
    {
        return scene.getStatistics().device.rfind("sim:", 0) == 0;
    }

    const Workplace _place;
    const Variable _grants;
};

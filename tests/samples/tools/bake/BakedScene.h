#pragma once

#include "device/recording/Recording.h"
#include "tests/samples/Shell.h"

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

/// A small scene that is baked in a moment: two points above a board, which move along x.
class Baking : public testing::Test
{
protected:
    Baking()
    {
        const auto* test = testing::UnitTest::GetInstance()->current_test_info();
        folder = testing::TempDir() + "midair-bake-" + test->name();
        std::filesystem::remove_all(folder);
        std::filesystem::create_directories(folder);
        write("scene.osgt", scene());
    }
    ~Baking() override { std::filesystem::remove_all(folder); }

    std::string at(const std::string& name) const { return folder + "/" + name; }
    void write(const std::string& name, const std::string& text) const
    {
        std::ofstream(at(name), std::ios::binary) << text;
    }
    std::string read(const std::string& name) const
    {
        std::ostringstream all;
        all << std::ifstream(at(name), std::ios::binary).rdbuf();
        return all.str();
    }

    /// From -10 to 10 mm in a second and back; \a settings of the scene, \a more nodes beside it.
    static std::string scene(const std::string& settings = "", const std::string& more = "")
    {
        return "#Ascii Scene\n#Version 161\n#Generator OpenSceneGraph 3.6.5\n"
               "osgMidair::HapticScene { UniqueID 1 Name \"small\" Children " +
               std::string(more.empty() ? "1" : "2") +
               " {\n"
               "  osg::MatrixTransform { UniqueID 2 DataVariance DYNAMIC UpdateCallback TRUE {\n"
               "    osg::AnimationPathCallback { UniqueID 3 AnimationPath TRUE {\n"
               "      osg::AnimationPath { UniqueID 4 TimeControlPointMap 3 {\n"
               "        Time 0 { Position -0.01 0 0 Rotation 0 0 0 1 Scale 1 1 1 }\n"
               "        Time 1 { Position 0.01 0 0 Rotation 0 0 0 1 Scale 1 1 1 }\n"
               "        Time 2 { Position -0.01 0 0 Rotation 0 0 0 1 Scale 1 1 1 }\n"
               "      } LoopMode LOOP } } } }\n"
               "  Children 1 { osgMidair::HapticPoints { UniqueID 5 Name \"two\"\n"
               "    Points 2 {\n 0 0 0.15\n 0 0.03 0.15\n } } } }\n" +
               more + "} FormatVersion 1 Array \"board\" " + settings + " }\n";
    }

    /// Runs midair-bake with neither grants nor progress.
    Outcome bake(const std::string& arguments, const std::string& variables = "") const
    {
        return shell("cd " + folder + " && env OSG_MIDAIR_GRANTS= XDG_CONFIG_HOME=/nonexistent " +
                     variables + " " MIDAIR_BIN "/midair-bake " + arguments + " --quiet");
    }
    static std::string frames(const std::string& more)
    {
        return "scene.osgt --frames 0:20 --fps 10 --chunk 4 " + more;
    }

    /// The fields of a recording; fails the test if it doesn't end with its mark.
    std::vector<midair::device::recording::Entry> entries(const std::string& name) const
    {
        using namespace midair::device::recording;
        const std::string bytes = read(name);
        std::vector<Entry> all;
        Reader reader(bytes, name);
        Stop stop = Stop::MORE;
        for (Entry entry; (stop = reader.next(entry)) == Stop::MORE;)
            all.push_back(entry);
        EXPECT_EQ(stop, Stop::END);
        return all;
    }

    std::string folder;
};

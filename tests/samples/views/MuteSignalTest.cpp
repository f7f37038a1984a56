#include "samples/views/MuteSignal.h"

#include <osg/ref_ptr>

#include <csignal>

#include <gtest/gtest.h>

using namespace midair::samples;

TEST(MuteSignal, MutesAndLetsPlayAtTheNextFrame)
{
    const osg::ref_ptr<osgMidair::HapticScene> scene = new osgMidair::HapticScene;
    catchMuteSignals();
    followMuteSignals(*scene);
    EXPECT_FALSE(scene->getMuted());
    std::raise(SIGUSR1);
    EXPECT_FALSE(scene->getMuted()) << "a handler may do nothing itself";
    followMuteSignals(*scene);
    EXPECT_TRUE(scene->getMuted());
    scene->setMuted(false);
    followMuteSignals(*scene);
    EXPECT_FALSE(scene->getMuted()) << "a signal counts once";
    std::raise(SIGUSR2);
    std::raise(SIGUSR1);
    followMuteSignals(*scene);
    EXPECT_TRUE(scene->getMuted()) << "the newest";
    std::raise(SIGUSR2);
    followMuteSignals(*scene);
    EXPECT_FALSE(scene->getMuted());
}

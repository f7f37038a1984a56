// What OSG finds by its plugins' names, and what a program without them asks for.

#include "tests/plugin/KitTest.h"

#include <osgMidair/FileFormats>

#include <osgDB/ObjectWrapper>
#include <osgDB/Registry>

#include <set>
#include <string>

#include <dlfcn.h>
#include <gtest/gtest.h>

using namespace osgMidair;

namespace
{

int readersOfHaptic()
{
    int count = 0;
    for (const auto& reader : osgDB::Registry::instance()->getReaderWriterList())
        count += reader->acceptsExtension("haptic") ? 1 : 0;
    return count;
}

} // namespace

TEST(Plugins, RegisterWhatTheirNamesSayOnce)
{
    findPlugins();
    osgDB::Registry* registry = osgDB::Registry::instance();
    for (const char* name : {"osgdb_serializers_osgmidair.so", "osgdb_haptic.so"})
        EXPECT_NE(registry->loadLibrary("osgPlugins-" + std::string(osgGetVersion()) + "/" + name),
                  osgDB::Registry::NOT_LOADED)
            << name;
    registerSerializers();
    registerLoader();
    EXPECT_EQ(readersOfHaptic(), 1);
    for (const std::string name :
         {"HapticScene", "HapticSurface", "HapticPoints", "HapticOverlays"})
    {
        osgDB::ObjectWrapper* wrapper =
            registry->getObjectWrapperManager()->findWrapper("osgMidair::" + name);
        ASSERT_NE(wrapper, nullptr) << name;
        const osg::ref_ptr<osg::Object> made = wrapper->createInstance();
        ASSERT_NE(made, nullptr) << name;
        EXPECT_EQ(made->className(), name);
        std::set<std::string> properties;
        for (const auto& serializer : wrapper->getSerializerList())
            EXPECT_TRUE(properties.insert(serializer->getName()).second)
                << name << " has " << serializer->getName() << " twice";
    }
}

// A program has one kit, whoever loads it: what a file makes is what the program's own types are.
TEST(Plugins, UseTheProgramsKit)
{
    findPlugins();
    osgDB::ObjectWrapper* wrapper =
        osgDB::Registry::instance()->getObjectWrapperManager()->findWrapper(
            "osgMidair::HapticScene");
    ASSERT_NE(wrapper, nullptr);
    const osg::ref_ptr<osg::Object> made = wrapper->createInstance();
    EXPECT_NE(dynamic_cast<HapticScene*>(made.get()), nullptr);
    Dl_info here{};
    Dl_info there{};
    const osg::ref_ptr<HapticScene> own = new HapticScene;
    ASSERT_NE(dladdr(*reinterpret_cast<void**>(own.get()), &here), 0);
    ASSERT_NE(dladdr(*reinterpret_cast<void**>(dynamic_cast<HapticScene*>(made.get())), &there), 0);
    EXPECT_STREQ(here.dli_fname, there.dli_fname);
}

#include "plugin/serializers/SinceVersion.h"

#include <osgMidair/HapticScene>

#include <osgDB/InputStream>
#include <osgDB/ObjectWrapper>
#include <osgDB/OutputStream>

#include <optional>
#include <string>

namespace
{

using osgMidair::HapticScene;

/// Nothing in the file: the end of it, when its folder and the user's options count.
class EndOfScene : public osgDB::BaseSerializer
{
public:
    EndOfScene() : osgDB::BaseSerializer(READ_WRITE_PROPERTY) {}

    const std::string& getName() const override
    {
        static const std::string name = "EndOfScene";
        return name;
    }

    bool read(osgDB::InputStream& is, osg::Object& object) override
    {
        // OSG's reader puts the file's folder in front, unless it reads from a stream.
        const osgDB::Options* options = is.getOptions();
        std::optional<std::string> folder;
        if (options && !options->getDatabasePathList().empty())
            folder = options->getDatabasePathList().front();
        static_cast<HapticScene&>(object).endReading(folder);
        return true;
    }

    bool write(osgDB::OutputStream&, const osg::Object&) override { return true; }
};

} // namespace

// .osgb is positional: this order is frozen. What comes later is added at the end under a higher format version.
REGISTER_CUSTOM_OBJECT_WRAPPER(osgMidair,
                               osgMidair_HapticScene,
                               new osgMidair::HapticScene,
                               osgMidair::HapticScene,
                               "osg::Object osg::Node osg::Group osgMidair::HapticScene")
{
    ADD_INT_SERIALIZER(FormatVersion, 0);
    ADD_BOOL_SERIALIZER(Enabled, true);
    wrapper->addSerializer(new osgDB::StringSerializer<MyClass>(
                               "Array", "octagon", &MyClass::getArray, &MyClass::wishArray),
                           osgDB::BaseSerializer::RW_STRING);
    wrapper->addSerializer(new osgDB::StringSerializer<MyClass>(
                               "Device", "sim:", &MyClass::getDevice, &MyClass::wishDevice),
                           osgDB::BaseSerializer::RW_STRING);
    ADD_MATRIXD_SERIALIZER(Calibration, osg::Matrixd());
    ADD_DOUBLE_SERIALIZER(MetresPerUnit, 1.0);
    ADD_DOUBLE_SERIALIZER(Temperature, 20.0);
    ADD_DOUBLE_SERIALIZER(Humidity, 0.5);
    ADD_DOUBLE_SERIALIZER(AirPressure, 101325.0);
    ADD_STRING_SERIALIZER(Solver, "");
    ADD_INT_SERIALIZER(MaxIterations, 0);
    ADD_DOUBLE_SERIALIZER(RmsTolerance, 1e-3);
    ADD_DOUBLE_SERIALIZER(Deadline, 0.0);
    ADD_DOUBLE_SERIALIZER(Lambda, 0.1);
    ADD_DOUBLE_SERIALIZER(Loudness, 1.0);
    ADD_BOOL_SERIALIZER(PhaseOnly, true);
    ADD_INT_SERIALIZER(Threads, 1);
    ADD_DOUBLE_SERIALIZER(MotionTolerance, 0.01);
    ADD_INT_SERIALIZER(MaxPoints, 0);
    wrapper->addSerializer(
        new osgDB::StringSerializer<MyClass>("Hands", "", &MyClass::getHands, &MyClass::wishHands),
        osgDB::BaseSerializer::RW_STRING);
    ADD_DOUBLE_SERIALIZER(Reach, 0.0);
    ADD_BOOL_SERIALIZER(Shadows, false);

    // Version 2
    using Number = osgMidair::SinceVersion<osgDB::PropByValSerializer<MyClass, double>, MyClass, 2>;
    wrapper->addSerializer(
        new Number("MaxPressure", 0.0, &MyClass::getMaxPressure, &MyClass::setMaxPressure),
        osgDB::BaseSerializer::RW_DOUBLE);

    // Version 3
    using Later = osgMidair::SinceVersion<osgDB::PropByValSerializer<MyClass, double>, MyClass, 3>;
    using Count = osgMidair::SinceVersion<osgDB::PropByValSerializer<MyClass, int>, MyClass, 3>;
    using Flag = osgMidair::SinceVersion<osgDB::PropByValSerializer<MyClass, bool>, MyClass, 3>;
    wrapper->addSerializer(new Count("Cycle", 1, &MyClass::getCycle, &MyClass::setCycle),
                           osgDB::BaseSerializer::RW_INT);
    wrapper->addSerializer(
        new Count("CycleSteps", 0, &MyClass::getCycleSteps, &MyClass::setCycleSteps),
        osgDB::BaseSerializer::RW_INT);
    wrapper->addSerializer(new Count("Subsets", 1, &MyClass::getSubsets, &MyClass::setSubsets),
                           osgDB::BaseSerializer::RW_INT);
    wrapper->addSerializer(
        new Later("FieldRate", 1000.0, &MyClass::getFieldRate, &MyClass::setFieldRate),
        osgDB::BaseSerializer::RW_DOUBLE);
    wrapper->addSerializer(
        new Flag("DenseOutlines", true, &MyClass::getDenseOutlines, &MyClass::setDenseOutlines),
        osgDB::BaseSerializer::RW_BOOL);
    wrapper->addSerializer(
        new Later(
            "MonitorInterval", 0.0, &MyClass::getMonitorInterval, &MyClass::setMonitorInterval),
        osgDB::BaseSerializer::RW_DOUBLE);

    // Version 4
    using Limit = osgMidair::SinceVersion<osgDB::PropByValSerializer<MyClass, double>, MyClass, 4>;
    wrapper->addSerializer(
        new Limit("MaxAmplitude", 1.0, &MyClass::getMaxAmplitude, &MyClass::setMaxAmplitude),
        osgDB::BaseSerializer::RW_DOUBLE);

    wrapper->addSerializer(new EndOfScene, osgDB::BaseSerializer::RW_USER); // stays the last
}

#include "plugin/serializers/SinceVersion.h"

#include <osgMidair/HapticSurface>

#include <osgDB/InputStream>
#include <osgDB/ObjectWrapper>
#include <osgDB/OutputStream>

// .osgb is positional: this order is frozen. What comes later is added at the end under a higher format version.
REGISTER_CUSTOM_OBJECT_WRAPPER(osgMidair,
                               osgMidair_HapticSurface,
                               new osgMidair::HapticSurface,
                               osgMidair::HapticSurface,
                               "osg::Object osg::Node osg::Group osgMidair::HapticSurface")
{
    using Property = osgMidair::HapticProperty;
    ADD_INT_SERIALIZER(FormatVersion, 0);
    ADD_BOOL_SERIALIZER(Enabled, true);
    ADD_DOUBLE_SERIALIZER(Pressure, 1.0);
    BEGIN_ENUM_SERIALIZER4(Property, PressureUnit, RELATIVE);
    ADD_ENUM_CLASS_VALUE(Property, RELATIVE);
    ADD_ENUM_CLASS_VALUE(Property, PASCAL);
    END_ENUM_SERIALIZER();
    ADD_DOUBLE_SERIALIZER(Spacing, 0.0);
    BEGIN_ENUM_SERIALIZER4(Property, Sampling, SURFACE);
    ADD_ENUM_CLASS_VALUE(Property, SURFACE);
    ADD_ENUM_CLASS_VALUE(Property, EDGES);
    ADD_ENUM_CLASS_VALUE(Property, VERTICES);
    END_ENUM_SERIALIZER();
    BEGIN_ENUM_SERIALIZER4(Property, Side, BOTH);
    ADD_ENUM_CLASS_VALUE(Property, BOTH);
    ADD_ENUM_CLASS_VALUE(Property, FRONT);
    ADD_ENUM_CLASS_VALUE(Property, BACK);
    END_ENUM_SERIALIZER();
    ADD_INT_SERIALIZER(Priority, 0);
    ADD_DOUBLE_SERIALIZER(ModulationFrequency, 0.0);
    ADD_DOUBLE_SERIALIZER(ModulationDepth, 1.0);
    BEGIN_ENUM_SERIALIZER4(Property, Intensity, UNIFORM);
    ADD_ENUM_CLASS_VALUE(Property, UNIFORM);
    ADD_ENUM_CLASS_VALUE(Property, VERTEX_COLOR);
    ADD_ENUM_CLASS_VALUE(Property, TEXTURE);
    END_ENUM_SERIALIZER();
    ADD_BOOL_SERIALIZER(TouchEvents, false);

    // Version 2
    using Channel = osgDB::EnumSerializer<MyClass, Property::Channel, void>;
    osg::ref_ptr<Channel> channel =
        new osgMidair::SinceVersion<Channel, MyClass, 2>("IntensityChannel",
                                                         Property::BRIGHTNESS,
                                                         &MyClass::getIntensityChannel,
                                                         &MyClass::setIntensityChannel);
    channel->add("BRIGHTNESS", Property::BRIGHTNESS);
    channel->add("RED", Property::RED);
    channel->add("GREEN", Property::GREEN);
    channel->add("BLUE", Property::BLUE);
    channel->add("ALPHA", Property::ALPHA);
    wrapper->addSerializer(channel.get(), osgDB::BaseSerializer::RW_ENUM);
    using Number = osgMidair::SinceVersion<osgDB::PropByValSerializer<MyClass, double>, MyClass, 2>;
    wrapper->addSerializer(
        new Number("IntensityLow", 0.0, &MyClass::getIntensityLow, &MyClass::setIntensityLow),
        osgDB::BaseSerializer::RW_DOUBLE);
    wrapper->addSerializer(
        new Number("IntensityHigh", 1.0, &MyClass::getIntensityHigh, &MyClass::setIntensityHigh),
        osgDB::BaseSerializer::RW_DOUBLE);
}

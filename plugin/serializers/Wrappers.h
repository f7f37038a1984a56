#pragma once

namespace osgDB
{
class ObjectWrapper;
}

namespace osgMidair
{

// Each registers one of the kit's classes with OSG's readers and writers at its first call. The
// class's own file in this folder defines it.
void registerProperties();
void registerHapticScene();
void registerHapticSurface();
void registerHapticSensation();
void registerHapticPoints();
void registerHapticOverlays();

/// Adds the file format's version to \a wrapper, before all properties of the class, also for a
/// program's own subclass.
void addFormatVersion(osgDB::ObjectWrapper& wrapper);

} // namespace osgMidair

#pragma once

namespace osgDB
{
class ObjectWrapper;
}

namespace osgMidair
{

// Each makes one of the kit's classes known to OSG's readers and writers, the first time that it is
// called. A class's own file of this folder defines it.
void registerProperties();
void registerHapticScene();
void registerHapticSurface();
void registerHapticPoints();
void registerHapticOverlays();

/// Adds the version of the file formats to \a wrapper, before all properties of the class, whatever
/// a class of a program's own that inherits from it begins with.
void addFormatVersion(osgDB::ObjectWrapper& wrapper);

} // namespace osgMidair

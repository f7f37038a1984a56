#pragma once

namespace osgMidair
{

/// How often a setter of any haptic node of the program has changed a property. Any thread.
unsigned int propertyChanges();
void notePropertyChange();

} // namespace osgMidair

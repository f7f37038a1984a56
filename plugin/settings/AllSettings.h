#pragma once

#include "haptics/base/settings/SettingTable.h"

#include <osgMidair/HapticProperty>
#include <osgMidair/HapticSettings>

/// Only scenes have matrices.
template<>
struct midair::base::Kinds<osgMidair::HapticSettings>
{
    using T = osgMidair::HapticSettings;
    using Member = std::
        variant<bool T::*, int T::*, double T::*, Choice<T>, std::string T::*, osg::Matrixd T::*>;
};

namespace osgMidair
{

using midair::base::Choice;
using midair::base::isSame;
using midair::base::Member;
using midair::base::Setting;
using midair::base::SettingTable;
using midair::base::Word;

/// The settings of a HapticScene.
const SettingTable<HapticSettings>& sceneSettings();

/// The properties of a HapticSurface or a tag.
const SettingTable<HapticProperty>& surfaceProperties();

} // namespace osgMidair

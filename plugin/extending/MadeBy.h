#pragma once

#include "haptics/base/ThrownBy.h"

#include <osg/ref_ptr>

#include <stdexcept>
#include <string>

namespace osgMidair
{

/// Makes a source with the application's registered factory \a make (HandSourceFactory,
/// HeadSourceFactory). Throws std::runtime_error with the reason on failure.
template<typename Source, typename Factory>
osg::ref_ptr<Source> madeBy(const Factory& make, const std::string& options)
{
    osg::ref_ptr<Source> source;
    std::string why;
    const std::string thrown = midair::base::thrownBy([&] { source = make(options, why); });
    if (!thrown.empty()) throw std::runtime_error("what makes it has thrown " + thrown);
    if (!source) throw std::runtime_error(why.empty() ? "it could not be made" : why);
    return source;
}

} // namespace osgMidair

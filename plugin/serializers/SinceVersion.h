#pragma once

#include <osgDB/Serializer>

namespace osgMidair
{

/// A serializer \a S of class \a C for a property that binary files below format version \a V don't hold: they are
/// positional, so that reading it there would take the bytes of what follows.
template<class S, class C, int V>
class SinceVersion : public S
{
public:
    using S::S;

    bool read(osgDB::InputStream& in, osg::Object& object) override
    {
        if (in.isBinary() && static_cast<const C&>(object).getReadVersion() < V) return true;
        return S::read(in, object);
    }
};

} // namespace osgMidair

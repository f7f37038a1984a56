#include "samples/views/LabelFont.h"

#include <osgDB/FileUtils>

#include <string>

namespace midair::samples
{

osg::ref_ptr<osgText::Font> labelFont()
{
    const std::string file = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
    osg::ref_ptr<osgText::Font> found;
    if (osgDB::fileExists(file)) found = osgText::readRefFontFile(file);
    return found ? found : osgText::Font::getDefaultFont();
}

} // namespace midair::samples

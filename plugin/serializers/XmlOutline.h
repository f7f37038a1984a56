#pragma once

#include <map>
#include <string>
#include <vector>

namespace osgMidair
{

/// A property in an XML file (.osgx), as OSG writes it: its value is in attributes called
/// "attribute" and "text".
struct XmlElement
{
    std::string name; ///< with "::" where the file has "--"
    int line = 0;     ///< 1 ..
    std::string attribute;
    std::string text;
    int words = 0; ///< of attribute, text and all elements inside, without its own name
};

/// Returns the properties of each object of an XML file, by UniqueID, in the file's order and
/// without the UniqueID. OSG's reader doesn't report where an object ends.
std::map<unsigned int, std::vector<XmlElement>> xmlObjects(const std::string& file);

/// Does for an XML file what repeatedNumber() does for an .osgt file.
std::string repeatedXmlNumber(const std::string& file);

/// Returns how many words \a text has, separated by blanks.
int countWords(const std::string& text);

} // namespace osgMidair

#include "samples/check/PagedFiles.h"

#include <osgMidair/FileFormats>

#include <osg/NodeVisitor>
#include <osg/PagedLOD>
#include <osg/ProxyNode>
#include <osgDB/Options>
#include <osgDB/Registry>

#include <deque>
#include <functional>

#include <fmt/format.h>

namespace midair::samples
{

namespace
{

/// A file that is the next child of a node.
struct Wanted
{
    osg::ref_ptr<osg::Group> parent;
    std::string name;
    osg::ref_ptr<osgDB::Options> options;
    std::function<void(std::deque<Wanted>&)> addNext; ///< asks for the parent's next file
};

template<typename Loader>
void addWanted(Loader& loader, std::deque<Wanted>& wanted)
{
    const unsigned int next = loader.getNumChildren();
    if (next >= loader.getNumFileNames() || loader.getFileName(next).empty()) return;
    wanted.push_back({&loader,
                      loader.getDatabasePath() + loader.getFileName(next),
                      dynamic_cast<osgDB::Options*>(loader.getDatabaseOptions()),
                      [&loader](std::deque<Wanted>& all) { addWanted(loader, all); }});
}

/// Finds the files that are not loaded, those of hidden nodes too.
class FindWanted : public osg::NodeVisitor
{
public:
    explicit FindWanted(std::deque<Wanted>& wanted) :
        osg::NodeVisitor(TRAVERSE_ALL_CHILDREN),
        _wanted(wanted)
    {
        setNodeMaskOverride(~0U);
    }

    void apply(osg::PagedLOD& node) override
    {
        addWanted(node, _wanted);
        traverse(node);
    }
    void apply(osg::ProxyNode& node) override
    {
        if (node.getLoadingExternalReferenceMode() != osg::ProxyNode::NO_AUTOMATIC_LOADING)
            addWanted(node, _wanted);
        traverse(node);
    }

private:
    std::deque<Wanted>& _wanted;
};

} // namespace

osgDB::ReaderWriter::ReadResult readSafely(const std::string& file, const osgDB::Options* options)
{
    osgDB::Registry* registry = osgDB::Registry::instance();
    return registry->getReadFileCallback() ? registry->getReadFileCallback()->readNode(
                                                 file, options ? options : registry->getOptions())
                                           : osgMidair::readModel(file, options);
}

std::vector<std::string> readPagedFiles(osg::Node& root)
{
    std::vector<std::string> notRead;
    std::deque<Wanted> wanted;
    FindWanted finder(wanted);
    root.accept(finder);
    for (int read = 0; !wanted.empty() && read < kMostPagedFiles; ++read)
    {
        const Wanted one = wanted.front();
        wanted.pop_front();
        const osg::ref_ptr<osg::Node> child = readSafely(one.name, one.options).getNode();
        if (!child)
        {
            notRead.push_back(
                fmt::format("{} '{}' names \"{}\", which can't be read; what it would "
                            "have is not judged",
                            one.parent->className(),
                            one.parent->getName(),
                            one.name));
            continue;
        }
        one.parent->addChild(child);
        one.addNext(wanted);
        child->accept(finder);
    }
    if (!wanted.empty())
        notRead.push_back(
            fmt::format("only the first {} files of PagedLODs and ProxyNodes are read, "
                        "not \"{}\" and {} more; what they have is not judged",
                        kMostPagedFiles,
                        wanted.front().name,
                        wanted.size() - 1));
    return notRead;
}

} // namespace midair::samples

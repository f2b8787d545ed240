"""An SROS2 policy, checked against the rules of its schema 0.2.0, and read as sros2 makes permissions of it."""

from xml.etree import ElementTree

# each element with its attributes, whether they must be there, and the elements in it: as in sros2's policy.xsd
CHILDREN = {
    'policy': {'enclaves'}, 'enclaves': {'enclave'}, 'enclave': {'profiles'}, 'profiles': {'profile'},
    'profile': {'topics', 'services'}, 'topics': {'topic'}, 'services': {'service'}, 'topic': set(), 'service': set(),
}
REQUIRED = {'policy': {'version'}, 'enclave': {'path'}, 'profile': {'ns', 'node'}}
RULES = {'topics': {'publish', 'subscribe'}, 'services': {'reply', 'request'}}


def faults(text):
    """Yield each violation of the schema; actions, which no node here has, are one."""
    root = ElementTree.fromstring(text.encode())  # noqa: S314 (our own file)
    if root.tag != 'policy' or root.get('version') != '0.2.0':
        yield f'{root.tag} of version {root.get("version")}'
    if len(root) != 1:
        yield f'{len(root)} elements in policy'
    for element in root.iter():
        if element.tag not in CHILDREN:
            yield f'unknown element {element.tag}'
            continue
        yield from (f'{child.tag} in {element.tag}' for child in element if child.tag not in CHILDREN[element.tag])
        given, required = set(element.keys()), REQUIRED.get(element.tag, set())
        if not required <= given <= required | RULES.get(element.tag, set()):
            yield f'attributes of {element.tag}: {sorted(given)}'
        if element.tag in RULES and not {*map(element.get, given)} <= {'ALLOW', 'DENY'}:
            yield f'values of {element.tag}: {[*map(element.get, given)]}'
        if element.tag != 'profile' and CHILDREN[element.tag] and len(element) == 0:
            yield f'nothing in {element.tag}'
        if not CHILDREN[element.tag] and not (element.text or '').strip('/~'):
            yield f'no name in {element.tag}'


def full_name(name, namespace, node):
    """Return a name of a profile as sros2's permissions.xsl does: absolute, private to the node, or relative."""
    prefix = namespace.rstrip('/') + '/'
    return name if name.startswith('/') else f'{prefix}{node}{name[1:]}' if name.startswith('~') else prefix + name


def allowed(text):
    """Return by enclave, and in it by full name of a node, the set of what it may do: (verb, full name)."""
    found = {}
    for enclave in ElementTree.fromstring(text.encode()).iter('enclave'):  # noqa: S314 (our own file)
        nodes = found.setdefault(enclave.get('path'), {})
        for profile in enclave.iter('profile'):
            own = profile.get('ns'), profile.get('node')
            nodes[full_name(own[1], *own)] = {
                (verb, full_name(one.text, *own)) for some in profile for verb, rule in some.items() if rule == 'ALLOW'
                for one in some}
    return found

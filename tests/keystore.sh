#!/bin/bash
# Makes an SROS2 keystore, or more enclaves in one, with openssl alone:
#
#     ROS_DOMAIN_ID=7 tests/keystore.sh FOLDER ENCLAVE...
#
# An enclave is a name such as / or /auv/plant_sim. Folders, files, keys, certificates, governance and permissions
# are those of `ros2 security create_keystore FOLDER` and `create_enclave FOLDER ENCLAVE`: one certificate authority for
# identities and permissions, everything encrypted, RTPS messages signed, nobody unauthenticated, and every enclave may
# use every ROS topic, service and action of the domain. Existing keys and certificates are kept.
set -euo pipefail

(($# >= 2)) || { sed -n '2,9s/^# \{0,1\}//p' "$0" >&2; exit 2; }
mkdir -p "$1"/{public,private,enclaves}
chmod 700 "$1/private"
cd "$1"
shift
domain=${ROS_DOMAIN_ID:-0}
days=3650

# key FILE: a private key on the curve that DDS Security names.
key() {
    (umask 077 && openssl genpkey -quiet -algorithm EC -pkeyopt ec_paramgen_curve:prime256v1 -out "$1")
}

# sign FILE.xml FILE.p7s: S/MIME with the text in the clear and the signature behind it.
sign() {
    openssl smime -sign -text -in "$1" -out "$2" -signer public/permissions_ca.cert.pem \
        -inkey private/permissions_ca.key.pem
}

if [[ ! -e private/ca.key.pem ]]; then
    key private/ca.key.pem
    openssl req -x509 -new -key private/ca.key.pem -sha256 -days $days -subj /CN=sros2CA -out public/ca.cert.pem \
        -config /dev/stdin <<<'[req]
distinguished_name = name
x509_extensions = authority
[name]
[authority]
basicConstraints = critical, CA:TRUE, pathlen:1'
    for role in identity permissions; do
        ln -s ca.cert.pem "public/${role}_ca.cert.pem"
        ln -s ca.key.pem "private/${role}_ca.key.pem"
    done
fi

cat >enclaves/governance.xml <<EOF
<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
    xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_governance.xsd">
  <domain_access_rules>
    <domain_rule>
      <domains>
        <id>$domain</id>
      </domains>
      <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
      <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
      <rtps_protection_kind>SIGN</rtps_protection_kind>
      <topic_access_rules>
        <topic_rule>
          <topic_expression>*</topic_expression>
          <enable_discovery_protection>true</enable_discovery_protection>
          <enable_liveliness_protection>true</enable_liveliness_protection>
          <enable_read_access_control>true</enable_read_access_control>
          <enable_write_access_control>true</enable_write_access_control>
          <metadata_protection_kind>ENCRYPT</metadata_protection_kind>
          <data_protection_kind>ENCRYPT</data_protection_kind>
        </topic_rule>
      </topic_access_rules>
    </domain_rule>
  </domain_access_rules>
</dds>
EOF
sign enclaves/governance.xml enclaves/governance.p7s

for enclave; do
    [[ $enclave == /* ]] || { echo "$enclave: an enclave's name begins with /" >&2; exit 2; }
    folder=enclaves${enclave%/}
    mkdir -p "$folder"
    for shared in public/identity_ca.cert.pem public/permissions_ca.cert.pem enclaves/governance.p7s; do
        [[ $shared -ef $folder/${shared##*/} ]] || ln -s --relative "$shared" "$folder/"
    done
    if [[ ! -e $folder/key.pem ]]; then
        key "$folder/key.pem"
        # Slashes part the fields of -subj, unless they are escaped.
        openssl req -new -key "$folder/key.pem" -subj "/CN=${enclave//\//\\/}" -config /dev/stdin <<<'[req]
distinguished_name = name
[name]' | openssl x509 -req -sha256 -days $days -CA public/identity_ca.cert.pem -CAkey private/identity_ca.key.pem \
            -set_serial "0x$(openssl rand -hex 19)" -extfile <(echo 'basicConstraints = CA:FALSE') \
            -out "$folder/cert.pem" 2>/dev/null
    fi
    allowed=$(printf '            <topic>%s</topic>\n' 'rt/*' 'rq/*Request' 'rr/*Reply' ros_discovery_info)
    cat >"$folder/permissions.xml" <<EOF
<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
    xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_permissions.xsd">
  <permissions>
    <grant name="$enclave">
      <subject_name>CN=$enclave</subject_name>
      <validity>
        <not_before>$(date --utc --date='1 day ago' +%FT%T)</not_before>
        <not_after>$(date --utc --date="$days days" +%FT%T)</not_after>
      </validity>
      <allow_rule>
        <domains>
          <id>$domain</id>
        </domains>
        <publish>
          <topics>
$allowed
          </topics>
        </publish>
        <subscribe>
          <topics>
$allowed
          </topics>
        </subscribe>
      </allow_rule>
      <default>DENY</default>
    </grant>
  </permissions>
</dds>
EOF
    sign "$folder/permissions.xml" "$folder/permissions.p7s"
done
